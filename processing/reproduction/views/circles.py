"""One whole circle of every instance, its views read or rendered when asked for: nothing is recorded first."""

from orbitscan.processing.classification.labelled_views import FEWEST_POINTS
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.training import data
from orbitscan.recorder.cloud import finite
from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.session import Session, View
from orbitscan.recorder.simulation import corpus


def open_instances(plan: Plan) -> dict[str, list[Session]]:
    """The circles of all instances before the lowest camera, by category. Raises what the dataset's reader raises.

    A virtual view is the same as the corpus's: it depends on its circle and its place in the turn alone.
    """
    if plan.dataset is None:
        lowest = min(corpus.ELEVATIONS_DEG, key=corpus.ELEVATIONS_DEG.__getitem__)
        circles = [circle for circle in corpus.plan(corpus.INSTANCES) if circle.video == lowest]
        sessions = [corpus.open_circle(circle, corpus.CAMERA) for circle in circles]
    else:
        sessions = data.open_circles(plan)
    found: dict[str, dict[str, Session]] = {category: {} for category in corpus.INSTANCES}
    for session in sorted(sessions, key=lambda session: session.info.elevation_deg or 0.0):
        found[str(session.info.category)].setdefault(str(session.info.instance), session)
    return {category: [instances[i] for i in sorted(instances, key=int)] for category, instances in found.items()}


def take_view(session: Session, share: float) -> View:
    """The view at a share (0 to 1) of the circle, or the next one that shows something.

    Raises InvalidOption where there is none, and what loading raises.
    """
    n = session.info.views
    for i in range(n):
        view = session.load((int(share * n) + i) % n)
        if len(finite(view.points)[0]) >= FEWEST_POINTS:
            return view
    problem = f"has no view of {FEWEST_POINTS} points"
    raise InvalidOption(session.info.name, problem, "mend the dataset, or name another")
