"""What the scripts of this folder share: small files with one peculiarity, and the run of their tests.

Each script tests what `kinfold-forecast` says about one engine. It writes its files itself.
`python check_ENGINE.py [ID ...]` runs the tests of these rules, or all. It prints `ok ID` or
`FAILED ID: reason` a line each, and ends with 1 if any failed.
"""

import os
import sys
import tempfile
import traceback

TESTS = {}


def rule(*ids):
    """Marks a function as the test of these rules."""
    def note(function):
        for id in ids:
            assert id not in TESTS, f"{id} has two tests"
            TESTS[id] = function
        return function
    return note


def main():
    """Runs the tests asked for, each in an empty folder of its own."""
    asked = sys.argv[1:] or list(TESTS)
    failed, done = 0, {}
    for id in asked:
        test = TESTS.get(id)
        if test is None:
            print(f"FAILED {id}: this script has no test of that name", flush=True)
            failed += 1
            continue
        if test not in done:
            with tempfile.TemporaryDirectory() as folder:
                os.chdir(folder)
                try:
                    test()
                    done[test] = None
                except Exception as error:  # every kind: what fails must not hide the rest
                    where = traceback.extract_tb(error.__traceback__)[-1]
                    done[test] = f"line {where.lineno}: {type(error).__name__}: {error}"
                os.chdir("/")
        reason = done[test]
        # Engines leave lines unfinished.
        print(f"\nok {id}" if reason is None else f"\nFAILED {id}: {reason}", flush=True)
        failed += reason is not None
    sys.exit(1 if failed else 0)


def refuses(load, words=""):
    """Whether loading raises an error that says these words."""
    try:
        load()
    except Exception as error:
        assert words in str(error), f"another error than expected: {error}"
        return True
    return False


def write(path, text):
    """Writes a file, with the folders that it needs; gives back its path."""
    if os.path.dirname(path):
        os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb" if isinstance(text, bytes) else "w") as file:
        file.write(text)
    return os.path.abspath(path)


BOX = '<geometry><box size="0.2 0.2 0.2"/></geometry>'
# A solid box of 0.2 m and 1 kg: 1/12 * (0.04 + 0.04) = 0.0066667.
SOLID = 0.0066667


def inertial(mass=1, i=(SOLID, SOLID, SOLID)):
    """The <inertial> of a link, about its own origin."""
    x, y, z = i
    return (f'<inertial><mass value="{mass}"/><inertia ixx="{x}" iyy="{y}" izz="{z}" '
            'ixy="0" ixz="0" iyz="0"/></inertial>')


def mesh(path, scale=""):
    """The <geometry> of a mesh."""
    scale = f' scale="{scale}"' if scale else ""
    return f'<geometry><mesh filename="{path}"{scale}/></geometry>'


def link(name, weight=inertial(), collision=BOX, visual="", more=""):
    """A link of one collision box, unless told otherwise."""
    collision = f"<collision>{collision}</collision>" if collision else ""
    visual = f"<visual>{visual}</visual>" if visual else ""
    return f'<link name="{name}">{weight}{visual}{collision}{more}</link>'


LIMIT = '<limit lower="-1" upper="1" effort="5" velocity="2"/>'


def joint(name="j", type="revolute", parent="base", child="a", axis="0 0 1", limit=LIMIT, more="",
          origin="0 0 0.5"):
    """A joint half a metre above its parent."""
    axis = f'<axis xyz="{axis}"/>' if axis else ""
    return (f'<joint name="{name}" type="{type}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{origin}"/>{axis}{limit}{more}</joint>')


def robot(*parts, path="m.urdf"):
    """Writes a URDF of these parts; gives back its path."""
    return write(path, '<?xml version="1.0"?>\n<robot name="m">\n' + "\n".join(parts) + "\n</robot>\n")


def pair(a=None, j=None, base=None, **more):
    """The usual file: a base, and one link that turns on it."""
    return robot(base or link("base"), a or link("a"), j or joint(), **more)


# Half a kilogram 0.2 m from a level hinge that rubs with 2 N m: gravity pulls with 0.98 N m.
LEVER = ('<inertial><origin xyz="0.2 0 0"/><mass value="0.5"/><inertia ixx=".001" iyy=".001" izz=".001" '
       'ixy="0" ixz="0" iyz="0"/></inertial>')


def lever(path="lever.urdf"):
    """Writes a lever that its friction could hold; gives back its path."""
    j = joint(axis="0 1 0", limit='<limit lower="-1.5" upper="1.5" effort="9" velocity="2"/>',
              more='<dynamics damping="0.04" friction="2"/>', origin="0 0 0")
    heavy = inertial(1, (.1, .1, .1))
    return robot(link("base", heavy, collision=""), link("a", LEVER, collision=""), j, path=path)


# A closed tetrahedron, a flat square, and a closed L: two boxes' outline drawn up.
TETRA = "v 0 0 0\nv 0.3 0 0\nv 0 0.2 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
SHEET = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"


def prism(outline, faces, height):
    """An OBJ of an outline drawn up along z; `faces` are its triangles, by corners from 1."""
    n = len(outline)
    lines = [f"v {x} {y} 0" for x, y in outline] + [f"v {x} {y} {height}" for x, y in outline]
    for a, b, c in faces:
        lines += [f"f {a} {c} {b}", f"f {a + n} {b + n} {c + n}"]
    for i in range(n):
        a, b = i + 1, (i + 1) % n + 1
        lines += [f"f {a} {b} {b + n}", f"f {a} {b + n} {a + n}"]
    return "\n".join(lines) + "\n"


# An L of 1 m, its arms 0.2 m thick: the inner corner lies at (0.2, 0.2).
ELL = prism([(0, 0), (1, 0), (1, .2), (.2, .2), (.2, 1), (0, 1)],
            [(1, 2, 3), (1, 3, 4), (1, 4, 5), (1, 5, 6)], .2)


def stl(path, obj=TETRA):
    """Writes the triangles of an OBJ text as a binary STL."""
    import struct
    v = [tuple(map(float, line.split()[1:])) for line in obj.splitlines() if line.startswith("v ")]
    f = [tuple(int(i) - 1 for i in line.split()[1:]) for line in obj.splitlines() if line.startswith("f ")]
    data = b" " * 80 + struct.pack("<I", len(f))
    for corners in f:
        data += struct.pack("<3f", 0, 0, 0) + b"".join(struct.pack("<3f", *v[i]) for i in corners) + b"\0\0"
    return write(path, data)


def glb(path, obj=TETRA):
    """Writes the triangles of an OBJ text as a GLB."""
    import json
    import struct
    v = [tuple(map(float, line.split()[1:])) for line in obj.splitlines() if line.startswith("v ")]
    f = [int(i) - 1 for line in obj.splitlines() if line.startswith("f ") for i in line.split()[1:]]
    points = b"".join(struct.pack("<3f", *p) for p in v)
    corners = b"".join(struct.pack("<I", i) for i in f)
    low, high = [min(c) for c in zip(*v)], [max(c) for c in zip(*v)]
    scene = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(points) + len(corners)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(points)},
                        {"buffer": 0, "byteOffset": len(points), "byteLength": len(corners)}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(v), "type": "VEC3", "min": low, "max": high},
            {"bufferView": 1, "componentType": 5125, "count": len(f), "type": "SCALAR"}],
    }
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    data = points + corners
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return write(path, struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body)
