"""Mesh files as other programs write them, read as triangles."""

import numpy as np
import pytest
import trimesh

from orbitscan.recorder.exceptions import UnreadableCloud
from orbitscan.recorder.formats.mesh_file import read_mesh
from orbitscan.recorder.simulation.objects.solids import box

MESH = box(0.3, 0.2, 0.1).painted((200, 100, 0))


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "off", "glb"])
def test_every_format_gives_the_triangles_that_were_written(tmp_path, ending):
    path = tmp_path / f"box.{ending}"
    trimesh.Trimesh(MESH.vertices, MESH.triangles, process=False).export(path)
    found = read_mesh(path)
    np.testing.assert_allclose(
        found.vertices[found.triangles], MESH.vertices[MESH.triangles].astype(np.float32), atol=1e-7
    )
    assert found.colors is None


@pytest.mark.parametrize("ending", ["ply", "glb", "obj"])
def test_colours_of_vertices_are_kept(tmp_path, ending):
    path = tmp_path / f"box.{ending}"
    trimesh.Trimesh(MESH.vertices, MESH.triangles, vertex_colors=MESH.colors, process=False).export(path)
    assert (read_mesh(path).colors == (200, 100, 0)).all()


def test_polygons_are_triangles_and_all_parts_of_a_scene_are_read(tmp_path):
    (tmp_path / "square.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    assert len(read_mesh(tmp_path / "square.obj").triangles) == 2
    scene = trimesh.Scene()
    for x in (0, 1):
        part = trimesh.Trimesh(MESH.vertices, MESH.triangles, process=False)
        scene.add_geometry(part, transform=trimesh.transformations.translation_matrix([x, 0, 0]))
    scene.export(tmp_path / "two.glb")
    found = read_mesh(tmp_path / "two.glb")
    assert len(found.triangles) == 2 * len(MESH.triangles)
    assert np.ptp(found.vertices, axis=0) == pytest.approx([1.3, 0.2, 0.1])


def test_a_glb_of_points_holds_no_triangles(tmp_path):
    trimesh.Scene(trimesh.PointCloud(MESH.vertices)).export(tmp_path / "points.glb")
    with pytest.raises(UnreadableCloud, match="holds no triangles that can be read; name a mesh file"):
        read_mesh(tmp_path / "points.glb")
