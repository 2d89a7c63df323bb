"""Which views are in dispute: they hang on a single pair, and another pair that seems right says otherwise.

Where two paths of pairs that share none lead from one view to another, a third that disagrees is outvoted. Where one
pair is all that holds them together, nothing tells which of the two is wrong.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from orbitscan.processing.reconstruction.components import Ends


def find_disputed(holding: Sequence[Ends], contradicting: Iterable[Ends], origin: int) -> set[int]:
    """Find the views that a single pair connects to the origin, and another pair elsewhere.

    `holding` are the pairs that connect views; views may be joined by several.
    """
    views = sorted({origin, *(view for ends in holding for view in ends)})
    number = {view: k for k, view in enumerate(views)}
    edges = np.array([[number[view] for view in ends] for ends in holding], dtype=int).reshape(-1, 2)
    against = [(number[a], number[b]) for a, b in contradicting if a in number and b in number]
    disputed: set[int] = set()
    for k in range(len(edges) if against else 0):
        rest = np.delete(edges, k, axis=0)
        graph = coo_matrix((np.ones(len(rest)), rest.T), shape=(len(views), len(views)))
        _, part = connected_components(graph, directed=False)
        cut = part != part[number[origin]]
        if any(cut[a] != cut[b] for a, b in against):
            disputed |= {view for view, beyond in zip(views, cut, strict=True) if beyond}
    return disputed
