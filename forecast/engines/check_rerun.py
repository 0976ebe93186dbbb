"""What Rerun's URDF reader does with small files: the tests of the rules `rerun.*`."""

import subprocess
import sys
import warnings

import rerun as rr
import rerun.urdf as ru
from common import *


def load(*parts):
    return ru.UrdfTree.from_file_path(robot(*parts))


def two(a=None, j=None):
    return load(link("base"), a or link("a"), j or joint())


def moved(j, by):
    """Translation of a joint's child, and what was warned of."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        made = j.compute_transform(by)
    return made.translation.as_arrow_array().to_pylist()[0], " ".join(str(w.message) for w in said)


def logged(tree):
    """What a recording of the model shows, as Rerun prints it."""
    rec = rr.RecordingStream("forecast")
    rec.save("out.rrd")
    tree.log_urdf_to_recording(rec)
    rec.flush()
    del rec
    said = subprocess.run([sys.executable, "-m", "rerun", "rrd", "print", "out.rrd", "-vv"],
                          capture_output=True, text=True, check=True)
    return said.stdout


@rule("rerun.collision-name-twice")
def collisions():
    same = f'<collision name="x">{BOX}</collision>' * 2
    paths = two(link("a", collision="", more=same)).get_collision_geometry_paths("a")
    assert len(paths) == 2 and len(set(paths)) == 1


@rule("rerun.visual-name-twice")
def visuals():
    same = f'<visual name="x">{BOX}</visual>' * 2
    paths = two(link("a", more=same)).get_visual_geometry_paths("a")
    assert len(paths) == 2 and len(set(paths)) == 1


@rule("rerun.axis-length")
def length():
    for axis, z in (("0 0 1", 1), ("0 0 2", 1.5)):
        at, _ = moved(two(j=joint(type="prismatic", axis=axis)).joints()[0], 0.5)
        assert abs(at[2] - z) < 1e-6


@rule("rerun.continuous-limit")
def continuous():
    assert not moved(two(j=joint(type="continuous")).joints()[0], 1.5)[1]
    assert "Clamping" in moved(two().joints()[0], 1.5)[1]


@rule("rerun.joint-unmoved")
def still():
    for kind in ("floating", "planar"):
        assert refuses(lambda: two(j=joint(type=kind)).joints()[0].compute_transform(0.5), "not supported")


@rule("rerun.range-missing")
def no_range():
    for limit in ('<limit effort="5" velocity="2"/>', ""):
        at, said = moved(two(j=joint(type="prismatic", limit=limit)).joints()[0], 0.5)
        assert abs(at[2] - 0.5) < 1e-6 and "Clamping" in said


@rule("rerun.range-one-sided")
def half():
    j, = two(j=joint(limit='<limit lower="-1" effort="5" velocity="2"/>')).joints()
    assert (j.limit_lower, j.limit_upper) == (-1, 0)


@rule("rerun.limit-incomplete")
def incomplete():
    for limit in ('<limit lower="-1" upper="1"/>', '<limit lower="-1" upper="1" effort="5"/>'):
        assert refuses(lambda: two(j=joint(limit=limit)), "missing field")


@rule("rerun.joint-type")
def kinds():
    assert refuses(lambda: two(j=joint(type="ball")), "unknown variant")


@rule("rerun.mesh-missing", "rerun.mesh-package")
def missing():
    write("pkg/t.obj", TETRA)
    write("t.obj", TETRA)
    assert "Asset3D" in logged(two(link("a", visual=mesh("t.obj"))))
    for name in ("none.obj", "package://pkg/t.obj"):
        assert "Asset3D" not in logged(two(link("a", visual=mesh(name))))
        assert "Asset3D" not in logged(two(link("a", collision=mesh(name))))


@rule("rerun.mimic-not-followed")
def mimic():
    tree = load(link("base"), link("a"), link("b"), joint(),
                joint("k", child="b", more='<mimic joint="j" multiplier="2" offset="0.1"/>'))
    j, k = tree.joints()
    turned = [x.compute_transform(0.5).quaternion.as_arrow_array().to_pylist() for x in (j, k)]
    assert k.mimic.joint == "j" and turned[0] == turned[1]


if __name__ == "__main__":
    main()
