"""Cloud files of every kind: what they hold comes out, and a file that is cut is an error."""

import io
import struct
from pathlib import Path

import numpy as np
import pytest

from orbitscan.recorder.exceptions import InvalidOption, UnreadableCloud
from orbitscan.recorder.formats import cloud_file, ply

POINTS = np.array([[0.5, -1.25, 2], [np.nan, np.nan, np.nan], [1e-3, 2e-3, -3e-3], [7, 8, 9]], np.float32)
COLORS = np.array([[0, 0, 0], [255, 255, 255], [1, 2, 3], [200, 100, 50]], np.uint8)


def write_ply(path, order="ascii", kind="float", before=(), color="uchar", newline=b"\n"):
    lines = ["ply", f"format {order} 1.0", "comment made for a test", "obj_info num_cols 512"]
    for name, count, fields in before:
        lines += [f"element {name} {count}", *(f"property {field}" for field in fields)]
    lines += ["element vertex 4", *(f"property {kind} {axis}" for axis in "xyz")]
    lines += [f"property {color} {channel}" for channel in ("red", "green", "blue")] if color else []
    lines += ["element face 1", "property list uchar int vertex_indices", "end_header"]
    head = newline.join(line.encode() for line in lines) + newline
    mark = ">" if "big" in order else "<"
    layout = [(axis, mark + {"float": "f4", "double": "f8"}[kind]) for axis in "xyz"]
    layout += [(c, mark + {"uchar": "u1", "float": "f4", "ushort": "u2"}[color]) for c in "rgb"] if color else []
    table = np.zeros(4, layout)
    for i, axis in enumerate("xyz"):
        table[axis] = POINTS[:, i]
    for i, c in enumerate("rgb" if color else ""):
        table[c] = {"uchar": COLORS[:, i], "float": COLORS[:, i] / 255, "ushort": COLORS[:, i] * 257.0}[color]
    if order == "ascii":
        rows = [b"1 2"] * sum(count for _, count, _ in before)
        rows += [" ".join(repr(number.item()) for number in row).encode() for row in table]
        path.write_bytes(head + newline.join([*rows, b"3 0 1 2"]) + newline)
    else:
        ahead = b"".join(b"\x01\x02" * count for _, count, _ in before)
        path.write_bytes(head + ahead + table.tobytes() + b"\x03" + struct.pack(mark + "3i", 0, 1, 2))


def write_pcd(path, data="ascii", kind="F4", rgb="F", count=None, pad=False):
    size, type_ = int(kind[1]), kind[0]
    fields = ["x", "y", "z", "rgb"] + (["_"] if pad else []) + ["imX"]
    sizes, types = [size] * 3 + [4] + ([1] if pad else []) + [4], [type_] * 3 + [rgb] + (["U"] if pad else []) + ["F"]
    counts = [1] * 4 + ([3] if pad else []) + [1]
    lines = [
        "# .PCD v0.7 - Point Cloud Data file format", "VERSION 0.7", "FIELDS " + " ".join(fields),
        "SIZE " + " ".join(map(str, sizes)), "TYPE " + " ".join(types), "COUNT " + " ".join(map(str, counts)),
        "WIDTH 2", "HEIGHT 2", "VIEWPOINT 0 0 0 1 0 0 0", f"POINTS {4 if count is None else count}", f"DATA {data}",
    ]  # fmt: skip
    packed = (COLORS.astype(np.uint32) << np.array([16, 8, 0], np.uint32)).sum(axis=1, dtype=np.uint32)
    layout = [(axis, f"<f{size}") for axis in "xyz"] + [("rgb", "<u4")]
    layout += [(f"p{i}", "u1") for i in range(3)] * pad + [("imX", "<f4")]
    table = np.zeros(4, layout)
    for i, axis in enumerate("xyz"):
        table[axis] = POINTS[:, i]
    table["rgb"], table["imX"] = packed, np.arange(4)
    body = table.tobytes()
    if data == "ascii":
        color = packed.view(np.float32) if rgb == "F" else packed
        text = [[*map(repr, map(float, POINTS[i])), f"{color[i]:.10g}", *["0"] * 3 * pad, str(i)] for i in range(4)]
        body = "\n".join(" ".join(row) for row in text).encode()
    elif data == "binary_compressed":
        columns = b"".join(table[name].tobytes() for name in table.dtype.names)
        literals = b"".join(
            bytes([len(columns[i : i + 32]) - 1]) + columns[i : i + 32] for i in range(0, len(columns), 32)
        )
        body = struct.pack("<II", len(literals), len(columns)) + literals
    path.write_bytes("\n".join(lines).encode() + b"\n" + body)


def assert_read(path, colors=COLORS):
    points, found = cloud_file.read(path)
    np.testing.assert_array_equal(points, POINTS)
    if colors is None:
        assert found is None
    else:
        assert found.dtype == np.uint8
        np.testing.assert_array_equal(found, colors)


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("kind", ["float", "double"])
@pytest.mark.parametrize("color", ["uchar", "ushort", "float", None])
def test_ply(tmp_path, order, kind, color):
    write_ply(tmp_path / "a.ply", order, kind, color=color)
    assert_read(tmp_path / "a.ply", COLORS if color else None)


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize("newline", [b"\n", b"\r\n"])
def test_ply_with_another_element_before_its_vertices(tmp_path, order, newline):
    write_ply(tmp_path / "a.ply", order, before=[("camera", 3, ("uchar a", "uchar b"))], newline=newline)
    assert_read(tmp_path / "a.ply")


def test_ply_with_lists_before_its_vertices(tmp_path):
    write_ply(tmp_path / "a.ply", before=[("range_grid", 2, ("list uchar int vertex_indices",))])
    assert_read(tmp_path / "a.ply")
    write_ply(tmp_path / "b.ply", "binary_little_endian", before=[("range_grid", 2, ("list uchar int i",))])
    with pytest.raises(UnreadableCloud, match="lists of its element 'range_grid'"):
        cloud_file.read(tmp_path / "b.ply")


@pytest.mark.parametrize("data", ["ascii", "binary", "binary_compressed"])
@pytest.mark.parametrize("kind", ["F4", "F8"])
@pytest.mark.parametrize("rgb", ["F", "U", "I"])
@pytest.mark.parametrize("pad", [False, True])
def test_pcd(tmp_path, data, kind, rgb, pad):
    write_pcd(tmp_path / "a.pcd", data, kind, rgb, pad=pad)
    assert_read(tmp_path / "a.pcd")


def test_pcd_as_open3d_compresses_it(open3d, tmp_path):
    rng = np.random.default_rng(0)
    points = np.round(rng.normal(size=(3000, 3)), 1)  # repeats, so that there is something to compress
    made = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    made.colors = open3d.utility.Vector3dVector(np.tile(COLORS, (750, 1)) / 255)
    open3d.io.write_point_cloud(str(tmp_path / "a.pcd"), made, compressed=True)
    found, colors = cloud_file.read(tmp_path / "a.pcd")
    np.testing.assert_array_equal(found, points.astype(np.float32))
    np.testing.assert_array_equal(colors, np.tile(COLORS, (750, 1)))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.xyz", "0.5 -1.25 2\nnan nan nan\n\n1e-3 2e-3 -3e-3\n7 8 9\n"),
        ("a.xyz", "# a comment\n0.5, -1.25, 2\nnan, nan, nan\n0.001,0.002,-0.003\n# another\n7,8,9"),
        ("a.xyz", "4\n0.5 -1.25 2 0.1 0.2 0.3\nnan nan nan 0 0 0\n1e-3 2e-3 -3e-3 0 1 0\n7 8 9 0 0 1\n"),
        ("a.csv", "x;y;z\n0.5;-1.25;2\nnan;nan;nan\n0.001;0.002;-0.003\n7;8;9\n"),
        ("a.csv", "id,Z,Y,X,what\n0,2,-1.25,0.5,mug\n1,nan,nan,nan,mug\n2,-0.003,0.002,0.001,mug\n3,9,8,7,mug\n"),
    ],
)
def test_text(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    points, colors = cloud_file.read(tmp_path / name)
    np.testing.assert_allclose(points, POINTS, rtol=1e-6)
    assert colors is None


@pytest.mark.parametrize("head", ["", "//X Y Z R G B\n", "x y z nx red green blue\n"])
def test_text_with_colors(tmp_path, head):
    extra = "0.5 " if "nx" in head else ""
    rows = [f"{i} {i} {i} {extra}" + " ".join(map(str, color)) for i, color in enumerate(COLORS)]
    (tmp_path / "a.xyz").write_text(head + "\n".join(rows))
    points, colors = cloud_file.read(tmp_path / "a.xyz")
    np.testing.assert_array_equal(points, np.arange(4)[:, None] * np.ones(3))
    np.testing.assert_array_equal(colors, COLORS)


@pytest.mark.parametrize(
    "head",
    [
        "id,origin_z,origin_y,origin_x",
        "t,Pz,Py,Px",
        "\ufeffid,z [m],y [m],x [m]",
        "nx,z_1,y_1,x_1",
        'what,"cz","cy","cx"',
    ],
)
def test_the_one_triple_of_columns_is_taken(tmp_path, head):
    rows = [f"9,{z},{y},{x}" for x, y, z in POINTS.tolist()]
    (tmp_path / "a.csv").write_text("\n".join([head, *rows]), encoding="utf-8")
    np.testing.assert_allclose(cloud_file.read(tmp_path / "a.csv")[0], POINTS, rtol=1e-6)


def test_normals_are_no_points_and_x_y_z_come_first(tmp_path):
    (tmp_path / "a.csv").write_text("nx,ny,nz,px,py,pz\n1,2,3,4,5,6\n")
    np.testing.assert_array_equal(cloud_file.read(tmp_path / "a.csv")[0], [[4, 5, 6]])
    (tmp_path / "a.csv").write_text("cx,cy,cz,x,y,z\n1,2,3,4,5,6\n")
    np.testing.assert_array_equal(cloud_file.read(tmp_path / "a.csv")[0], [[4, 5, 6]])


def test_columns_are_said_where_several_could_be_meant(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("Cx,Cy,Cz,px,py,pz,red,green,blue\n1,2,3,4,5,6,70,80,90\n")
    with pytest.raises(
        InvalidOption, match=r"a\.csv: may hold its points in cx,cy,cz and px,py,pz; pass columns=\('cx', "
    ):
        cloud_file.read(path)
    points, colors = cloud_file.read(path, ("px", "Cy", "pz"))
    np.testing.assert_array_equal(points, [[4, 2, 6]])
    np.testing.assert_array_equal(colors, [[70, 80, 90]])
    with pytest.raises(InvalidOption, match=r"columns=\('px', 'py', 'up'\): .*a\.csv has no column up among cx, cy, "):
        cloud_file.read(path, ("px", "py", "up"))


def test_columns_are_for_text_with_a_line_of_names(tmp_path):
    (tmp_path / "a.xyz").write_text("1 2 3\n")
    with pytest.raises(InvalidOption, match="has no line of column names"):
        cloud_file.read(tmp_path / "a.xyz", ("px", "py", "pz"))
    write_pcd(tmp_path / "a.pcd")
    with pytest.raises(InvalidOption, match="is no text file; leave it out"):
        cloud_file.read(tmp_path / "a.pcd", ("px", "py", "pz"))


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("shape", [(4,), (2, 2)])
def test_npy(tmp_path, kind, shape):
    np.save(tmp_path / "a.npy", POINTS.astype(kind).reshape(*shape, 3))
    assert_read(tmp_path / "a.npy", None)
    np.save(tmp_path / "a.npy", np.hstack([POINTS, COLORS]).astype(kind).reshape(*shape, 6))
    assert_read(tmp_path / "a.npy")
    normals = np.tile(np.array([[0, 0, 1]]), (4, 1))
    np.save(tmp_path / "a.npy", np.hstack([POINTS, normals]).astype(kind).reshape(*shape, 6))
    assert_read(tmp_path / "a.npy", None)


def test_a_cloud_of_no_points_is_a_cloud(tmp_path):
    (tmp_path / "a.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    )
    write_pcd(tmp_path / "a.pcd", count=0)
    np.save(tmp_path / "a.npy", np.empty((0, 3)))
    for name in ("a.ply", "a.pcd", "a.npy"):
        assert cloud_file.read(tmp_path / name)[0].shape == (0, 3)


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize("back", [20, 40, 60])
def test_a_ply_that_is_cut_is_refused(tmp_path, order, back):
    write_ply(tmp_path / "a.ply", order)
    content = (tmp_path / "a.ply").read_bytes()
    (tmp_path / "a.ply").write_bytes(content[:-back])
    with pytest.raises(UnreadableCloud, match=r"a\.ply: no readable PLY cloud \("):
        cloud_file.read(tmp_path / "a.ply")


@pytest.mark.parametrize("data", ["ascii", "binary", "binary_compressed"])
@pytest.mark.parametrize("back", [1, 30, 75])
def test_a_pcd_that_is_cut_is_refused(tmp_path, data, back):
    write_pcd(tmp_path / "a.pcd", data)
    content = (tmp_path / "a.pcd").read_bytes()
    (tmp_path / "a.pcd").write_bytes(content[: -back - (data == "ascii")])
    with pytest.raises(UnreadableCloud, match=r"a\.pcd: no readable PCD cloud \("):
        cloud_file.read(tmp_path / "a.pcd")


def npy(array):
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=True)
    return stream.getvalue()


PLY_HEAD = b"ply\nformat ascii 1.0\nelement vertex 1\n"
PCD_HEAD = b"VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\n"


@pytest.mark.parametrize(
    ("name", "content", "what"),
    [
        ("a.ply", b"", "the file is empty"),
        ("a.ply", b"solid cube\n", "does not start with 'ply'"),
        ("a.ply", PLY_HEAD, "its header is cut"),
        ("a.ply", PLY_HEAD + b"nonsense here\nend_header\n", "its header holds 'nonsense here'"),
        ("a.ply", PLY_HEAD + b"property float a\nend_header\n1\n", "no x y z among its fields a"),
        ("a.ply", PLY_HEAD + b"property list uchar int x\nend_header\n1 1\n", "its vertices hold lists"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement face 0\nend_header\n", "declares no vertices"),
        ("a.pcd", b"\x00\x01\x02" * 200, "no DATA line"),
        ("a.pcd", PCD_HEAD + b"DATA ascii\na b c\n", "could not convert"),
        ("a.pcd", PCD_HEAD + b"DATA zipped\n", "its data are 'zipped'"),
        ("a.pcd", PCD_HEAD.replace(b"FIELDS x y z", b"FIELDS a b c") + b"DATA ascii\n1 2 3\n", "no x y z"),
        ("a.pcd", PCD_HEAD.replace(b"SIZE 4 4 4", b"SIZE 4 4") + b"DATA ascii\n1 2 3\n", "no readable PCD"),
        ("a.pcd", PCD_HEAD.replace(b"SIZE 4 4 4", b"SIZE 3 3 3") + b"DATA ascii\n1 2 3\n", "fields make no sense"),
        ("a.pcd", PCD_HEAD.replace(b"TYPE F", b"TYPE a") + b"DATA ascii\n1 2 3\n", "field x has the type 'a'"),
        ("a.pcd", PCD_HEAD.replace(b"POINTS 1", b"POINTS 9000000000000") + b"DATA binary\n", "is cut: 0 of the 9,000"),
        ("a.pcd", b"FIELDS x y z\nSIZE 4 4 4\nDATA ascii\n", "no TYPE line"),
        ("a.xyz", b"", "the file is empty"),
        ("a.xyz", b"# nothing\n1 2\n", "no line of three numbers"),
        ("a.xyz", b"1 2 3\n4 5\n", "no readable XYZ"),
        ("a.npy", b"not numpy", "no readable NPY"),
        ("a.npy", npy(np.zeros((5, 2))), "an array .5, 2. of float64"),
        ("a.npy", npy(np.array([None])), "no readable NPY"),
        ("a.obj", b"v 0 0 0\n", "not a known cloud format"),
    ],
)
def test_what_is_no_cloud_is_refused_in_a_sentence(tmp_path, name, content, what):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(UnreadableCloud, match=what) as caught:
        cloud_file.read(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_refused():
    with pytest.raises(UnreadableCloud, match="No such file"):
        cloud_file.read(Path("nowhere/a.ply"))


def test_random_bytes_never_raise_anything_else(tmp_path):
    rng = np.random.default_rng(0)
    write_pcd(tmp_path / "a.pcd", "binary_compressed")
    write_ply(tmp_path / "a.ply", "binary_little_endian")
    for name in ("a.pcd", "a.ply"):
        content = (tmp_path / name).read_bytes()
        for _ in range(300):
            damaged = bytearray(content)
            for position in rng.integers(0, len(content), 3):
                damaged[position] = rng.integers(256)
            (tmp_path / name).write_bytes(damaged)
            try:
                points, _ = cloud_file.read(tmp_path / name)
            except UnreadableCloud:
                continue
            assert points.shape[1] == 3


def test_real_scans_hold_what_they_declare(data):
    for path in sorted((data / "stanford_bunny").glob("*.ply")):
        declared = int(path.read_bytes()[:2000].split(b"element vertex ")[1].split()[0])
        points, colors = cloud_file.read(path)
        assert points.shape == (declared, 3)
        assert colors is None
        assert np.abs(points).max() < 0.3
    points, colors = cloud_file.read(data / "washington/rgbd-dataset/cap/cap_1/cap_1_1_1.pcd")
    assert (points.shape, colors.shape) == ((16776, 3), (16776, 3))
    np.testing.assert_array_equal(colors[0], [214, 202, 208])
    car = sorted((data / "lidarnet_v2/Car").glob("*.csv"))[0]
    with pytest.raises(InvalidOption, match="origin_x,origin_y,origin_z and relative_x,relative_y,relative_z; pass"):
        cloud_file.read(car)
    points, _ = cloud_file.read(car, ("origin_x", "origin_y", "origin_z"))
    np.testing.assert_allclose(points[0], [41.8929, -4.90469, 3.06172])


@pytest.mark.parametrize("colors", [None, COLORS])
def test_what_is_written_as_ply_is_read_again(tmp_path, colors):
    ply.write(tmp_path / "cloud.ply", POINTS, colors)
    points, read_colors = cloud_file.read(tmp_path / "cloud.ply")
    assert np.array_equal(points, POINTS, equal_nan=True)
    assert colors is None if read_colors is None else np.array_equal(read_colors, COLORS)
