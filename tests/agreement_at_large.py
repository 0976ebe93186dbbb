"""What MuJoCo makes of URDF and MJCF files in given poses: depths, masses, centre of mass.

    agreement_at_large.py QUESTIONS    one JSON line per line of the file QUESTIONS
    agreement_at_large.py --one        that process: a question on stdin, an answer on stdout

A question is {"file": PATH, "poses": [{joint: value}], "ours": [{"a|b": depth}]}, values told from
the pose the file is written in. An answer has for each pose the depth in
metres of every two rigid bodies that overlap ("a|b", sorted names of the first bodies welded
together); the mass in kg and the principal moments of every rigid body that has a name; and the
centre of mass of all in the first pose. Files with masses that MuJoCo refuses are asked for
depths alone.
"""

import itertools
import json
import os
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as tree

ROOT = "root_of_it"
FREE = """<link name="outside_of_it"/><joint name="freedom" type="floating">
<parent link="outside_of_it"/><child link="{root}"/></joint>
<mujoco><compiler strippath="false" discardvisual="true" inertiafromgeom="{weighed}" balanceinertia="{balance}"
{bounds}/></mujoco></robot>"""


def found(name, folder):
    """Where a URDF's mesh lies: beside the file, or at or beside one of the folders above it."""
    scheme, _, rest = name.rpartition("://")
    if scheme not in ("package", "model"):
        return os.path.join(folder, rest)
    tails = [rest, rest.partition("/")[2]]
    above = os.path.abspath(folder)
    while True:
        for tail in tails:
            if os.path.isfile(os.path.join(above, tail)):
                return os.path.join(above, tail)
        if above == os.path.dirname(above):
            return name
        above = os.path.dirname(above)


def of_urdf(path, lenient):
    """MuJoCo's model of a copy whose root floats, so that no mass melts into the world."""
    import mujoco

    robot = tree.parse(path).getroot()
    folder = os.path.dirname(os.path.abspath(path))
    for link in robot.findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
        for mesh in link.iter("mesh"):
            mesh.set("filename", found(mesh.get("filename"), folder))
    children = {joint.find("child").get("link") for joint in robot.findall("joint")}
    (root,) = [link for link in robot.findall("link") if link.get("name") not in children]
    back = {}
    if root.get("name") == "world":
        back[ROOT] = "world"
        root.set("name", ROOT)
        for joint in robot.findall("joint"):
            if joint.find("parent").get("link") == "world":
                joint.find("parent").set("link", ROOT)
    for own in robot.findall("mujoco"):
        robot.remove(own)
    text = tree.tostring(robot, encoding="unicode")
    bounds = 'boundmass="1e-9" boundinertia="1e-12"' if lenient else ""
    weighed, balance = "false", "true" if lenient else "false"
    more = FREE.format(root=root.get("name"), bounds=bounds, weighed=weighed, balance=balance)
    with tempfile.TemporaryDirectory() as place:
        copy = os.path.join(place, "asset.urdf")
        with open(copy, "w") as file:
            file.write(text[: text.rindex("</robot>")] + more)
        return mujoco.MjModel.from_xml_path(copy), back


def load(path):
    """The model, what its bodies are called in the file, and whether its masses are the file's."""
    import mujoco

    if tree.parse(path).getroot().tag == "mujoco":
        return mujoco.MjModel.from_xml_path(path), {}, True
    try:
        return (*of_urdf(path, False), True)
    except ValueError:
        return (*of_urdf(path, True), False)


def core(model, data, geom):
    """Points in the world whose hull, thickened by a radius, is the geom; balls bent by their scale
    are taken as hulls of 10,000 points."""
    import mujoco
    import numpy as np

    size, kind, radius = model.geom_size[geom], model.geom_type[geom], 0.0
    kinds = mujoco.mjtGeom
    if kind == kinds.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        points = model.mesh_vert[first : first + count].astype(float)
    elif kind == kinds.mjGEOM_SPHERE:
        points, radius = np.zeros((1, 3)), size[0]
    elif kind == kinds.mjGEOM_CAPSULE:
        points, radius = np.array([[0, 0, -size[1]], [0, 0, size[1]]]), size[0]
    elif kind == kinds.mjGEOM_BOX:
        points = np.array(list(itertools.product(*((-s, s) for s in size))))
    elif kind == kinds.mjGEOM_CYLINDER:
        turn = np.linspace(0, 2 * np.pi, 721)[:-1]
        ring = np.stack([size[0] * np.cos(turn), size[0] * np.sin(turn)], 1)
        points = np.concatenate([np.c_[ring, np.full(720, z)] for z in (-size[1], size[1])])
    else:
        k = np.arange(10000) + 0.5
        up, turn = np.arccos(1 - 2 * k / 10000), np.pi * (1 + 5**0.5) * k
        ball = np.stack([np.sin(up) * np.cos(turn), np.sin(up) * np.sin(turn), np.cos(up)], 1)
        points = ball * size
    return points @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom], radius


def way_out(model, data, i, j):
    """The shortest way out, metres, from the hull of all differences of their points, found by
    planes: each facet's own is one more direction to be asked for its farthest difference."""
    import numpy as np
    from scipy.spatial import ConvexHull

    (a, r), (b, s) = core(model, data, i), core(model, data, j)

    def farthest(directions):
        return a[(a @ directions.T).argmax(0)] - b[(b @ directions.T).argmin(0)]

    k = np.arange(200) + 0.5
    up, turn = np.arccos(1 - 2 * k / 200), np.pi * (1 + 5**0.5) * k
    start = np.stack([np.sin(up) * np.cos(turn), np.sin(up) * np.sin(turn), np.cos(up)], 1)
    points = np.unique(farthest(start).round(12), axis=0)
    for _ in range(60):
        try:
            hull = ConvexHull(points)
        except Exception:
            break
        facets = hull.equations
        near = facets[np.argsort(-facets[:, 3])[:64], :3]
        more = np.unique(np.concatenate([points, farthest(near).round(12)]), axis=0)
        if len(more) == len(points):
            return max(0.0, float(-facets[:, 3].max()) + r + s)
        points = more
    # Differences that span no body, or too many facets: the least over many directions.
    k = np.arange(200000) + 0.5
    up, turn = np.arccos(1 - 2 * k / 200000), np.pi * (1 + 5**0.5) * k
    all = np.stack([np.sin(up) * np.cos(turn), np.sin(up) * np.sin(turn), np.cos(up)], 1)
    all = np.concatenate([all, -all])
    reach = np.concatenate([(a @ d.T).max(0) - (b @ d.T).min(0) for d in np.array_split(all, 100)])
    return max(0.0, float(reach.min()) + r + s)


def answer(question):
    import mujoco
    import numpy as np

    model, back, weighed = load(question["file"])
    data, fromto = mujoco.MjData(model), np.zeros(6)
    weld = model.body_weldid
    names = [back.get(model.body(b).name, model.body(b).name) for b in range(model.nbody)]
    touch = (model.geom_contype | model.geom_conaffinity) != 0
    flat = np.isin(model.geom_type, [mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD])
    touch &= model.geom_type != mujoco.mjtGeom.mjGEOM_SDF
    of = weld[model.geom_bodyid]
    touch &= np.array([bool(names[b]) for b in of], dtype=bool)
    touch &= ~flat
    said = {"depths": [], "exact": [], "masses": {}, "named": [n for n in names if n]}
    for k, pose in enumerate(question["poses"]):
        mujoco.mj_resetData(model, data)
        for joint, value in pose.items():
            number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint)
            if number >= 0 and model.jnt_type[number] in (2, 3):
                address = model.jnt_qposadr[number]
                data.qpos[address] = model.qpos0[address] + value
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        if k == 0:
            said["centre"] = data.subtree_com[0].tolist() if weighed and model.body_subtreemass[0] > 0 else None
        depths = {}
        for i, j in itertools.combinations(np.nonzero(touch)[0].tolist(), 2):
            reach = model.geom_rbound[i] + model.geom_rbound[j]
            if of[i] == of[j] or np.linalg.norm(data.geom_xpos[i] - data.geom_xpos[j]) > reach:
                continue
            depth = -mujoco.mj_geomDistance(model, data, i, j, 0.01, fromto)
            key = "|".join(sorted((names[of[i]], names[of[j]])))
            depths.setdefault(key, []).append((depth, i, j))
        told, exact = {}, {}
        for key, all in depths.items():
            told[key] = max(0.0, max(all)[0])
            if abs(told[key] - question["ours"][k].get(key, 0.0)) > max(0.0005, 0.02 * told[key]):
                near = [pair for pair in all if pair[0] > -0.001]
                exact[key] = max([0.0, *(way_out(model, data, i, j) for _, i, j in near)])
        said["depths"].append(told)
        said["exact"].append(exact)
    mujoco.mj_resetData(model, data)
    mujoco.mj_kinematics(model, data)
    for first in sorted(set(weld.tolist()) - {0}):
        if not weighed or not names[first] or model.body_mocapid[first] >= 0:
            continue
        bodies = [b for b in range(model.nbody) if weld[b] == first]
        masses = model.body_mass[bodies]
        if masses.sum() <= 0:
            continue
        centre = (masses[:, None] * data.xipos[bodies]).sum(0) / masses.sum()
        inertia = np.zeros((3, 3))
        for body in bodies:
            turn, arm = data.ximat[body].reshape(3, 3), data.xipos[body] - centre
            inertia += turn @ np.diag(model.body_inertia[body]) @ turn.T
            inertia += model.body_mass[body] * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        moments = model.body_inertia[first] if len(bodies) == 1 else np.linalg.eigvalsh(inertia)
        said["masses"][names[first]] = [float(masses.sum()), *np.asarray(moments).tolist()]
    return said


def ask(question):
    command = [sys.executable, __file__, "--one"]
    done = subprocess.run(command, input=question, capture_output=True, text=True, timeout=600)
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode == 0 and lines:
        return json.loads(lines[-1])
    return {"error": f"exit {done.returncode}: {(done.stderr or done.stdout).strip()[-600:]}"}


def main(arguments):
    if arguments[0] == "--one":
        print(json.dumps(answer(json.loads(sys.stdin.read()))))
        return
    with open(arguments[0]) as questions:
        for question in questions:
            print(json.dumps(ask(question)), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
