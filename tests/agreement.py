"""What MuJoCo and Pinocchio make of URDFs in given poses: depths, masses, motion under a torque.

    agreement.py QUESTIONS        one JSON line per client and line of the file QUESTIONS
    agreement.py --one CLIENT     that process: a question on stdin, an answer on stdout

A question is {"file": URDF, "poses": [{joint: value}], "drives": {joint: travel}}. An answer has,
for each pose, the depth in metres of every two bodies that overlap ("a|b", sorted names of the
bodies' first links, the shortest way out of the deepest pair of convex pieces); mass in kg, centre
of mass and inertia about it (row by row, root frame, at rest); and from MuJoCo, for each drive, the
effort that moves it by about `travel` in a second and where it then is, all else held, friction
and gravity off, damping as the file has it.
"""

import itertools
import json
import os
import shutil
import subprocess
import sys
import tempfile

FREE = """<link name="outside_of_it"/><joint name="freedom" type="floating">
<parent link="outside_of_it"/><child link="{root}"/></joint>
<mujoco><compiler strippath="false" discardvisual="true" balanceinertia="false"/></mujoco></robot>"""
HELD = 1e9  # armature of what is not to move, kg m^2
SECOND, STEP = 1.0, 0.001


def deepest(found, pair, depth):
    key = "|".join(sorted(pair))
    if depth > found.get(key, 0.0):
        found[key] = depth


def near_pairs(places, radii, bodies):
    """Pairs of shapes of different bodies whose bounding spheres meet."""
    for i, j in itertools.combinations(range(len(places)), 2):
        gap = ((places[i] - places[j]) ** 2).sum()
        if bodies[i] != bodies[j] and gap <= (radii[i] + radii[j]) ** 2:
            yield i, j


def free_model(path):
    """MuJoCo's model of a copy whose root floats, so that no mass melts into the world."""
    import mujoco
    import xml.etree.ElementTree as tree

    robot = tree.parse(path).getroot()
    children = {joint.find("child").get("link") for joint in robot.findall("joint")}
    (root,) = [link.get("name") for link in robot.findall("link") if link.get("name") not in children]
    for own in robot.findall("mujoco"):
        robot.remove(own)
    text = tree.tostring(robot, encoding="unicode")
    with tempfile.TemporaryDirectory() as folder:
        meshes = os.path.join(os.path.dirname(path), "meshes")
        if os.path.isdir(meshes):
            shutil.copytree(meshes, os.path.join(folder, "meshes"))
        copy = os.path.join(folder, "asset.urdf")
        with open(copy, "w") as file:
            file.write(text[: text.rindex("</robot>")] + FREE.format(root=root))
        return mujoco.MjModel.from_xml_path(copy)


def mujoco_depths(model, pose):
    import mujoco
    import numpy as np

    data, fromto, found = mujoco.MjData(model), np.zeros(6), {}
    for joint, value in pose.items():
        data.qpos[model.joint(joint).qposadr[0]] = value
    mujoco.mj_forward(model, data)
    bodies, names = model.geom_bodyid, [model.body(b).name for b in range(model.nbody)]
    for a, b in near_pairs(data.geom_xpos, model.geom_rbound, bodies):
        depth = -mujoco.mj_geomDistance(model, data, a, b, 0.01, fromto)
        deepest(found, (names[bodies[a]], names[bodies[b]]), depth)
    return found


def mujoco_mass(model):
    import mujoco
    import numpy as np

    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mass, centre = model.body_subtreemass[0], data.subtree_com[0]
    inertia = np.zeros((3, 3))
    for body in range(1, model.nbody):
        turn, arm = data.ximat[body].reshape(3, 3), data.xipos[body] - centre
        inertia += turn @ np.diag(model.body_inertia[body]) @ turn.T
        inertia += model.body_mass[body] * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return {"mass": mass, "centre": centre.tolist(), "inertia": inertia.flatten().tolist()}


def mujoco_push(model, joint, travel):
    import mujoco
    import numpy as np

    dof = model.joint(joint).dofadr[0]
    kept = model.dof_armature.copy()
    model.dof_armature[:] = HELD
    model.dof_armature[dof] = 0.0

    def moved(effort):
        data = mujoco.MjData(model)
        data.qfrc_applied[dof] = effort
        for _ in range(round(SECOND / STEP)):
            mujoco.mj_step(model, data)
        return float(data.qpos[model.joint(joint).qposadr[0]])

    data, matrix = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, matrix)
    trial = 0.01 * float(matrix[dof, dof])
    effort = trial * travel / moved(trial)
    answer = [effort, moved(effort)]
    model.dof_armature[:] = kept
    return answer


def mujoco_client(question):
    import mujoco

    model = free_model(question["file"])
    answer = {"depths": [mujoco_depths(model, pose) for pose in question["poses"]]}
    answer |= mujoco_mass(model)
    off = ["GRAVITY", "CONTACT", "LIMIT", "FRICTIONLOSS", "EQUALITY"]
    for flag in off:
        model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}"))
    model.opt.timestep = STEP
    drives = question["drives"].items()
    answer["pushed"] = {joint: mujoco_push(model, joint, travel) for joint, travel in drives}
    return answer


def pinocchio_client(question):
    import coal
    import numpy as np
    import pinocchio as pin

    path = question["file"]
    folder = os.path.dirname(os.path.abspath(path))
    model = pin.buildModelFromUrdf(path)
    shapes = pin.buildGeomFromUrdf(model, path, pin.GeometryType.COLLISION, package_dirs=[folder])
    hulls = []
    for shape in shapes.geometryObjects:
        if isinstance(shape.geometry, coal.BVHModelBase):
            shape.geometry.buildConvexHull(True, "Qt")
            hulls.append(shape.geometry.convex)
        else:
            hulls.append(shape.geometry)
        hulls[-1].computeLocalAABB()
    bodies = [shape.parentJoint for shape in shapes.geometryObjects]
    first = {}
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY:
            first.setdefault(frame.parentJoint, frame.name)
    data, places = model.createData(), shapes.createData()
    request, found = coal.DistanceRequest(True, True), []
    for pose in question["poses"]:
        q = pin.neutral(model)
        for joint, value in pose.items():
            of = model.joints[model.getJointId(joint)]
            turned = [np.cos(value), np.sin(value)]
            q[of.idx_q:of.idx_q + of.nq] = value if of.nq == 1 else turned
        pin.updateGeometryPlacements(model, data, shapes, places, q)
        at = [coal.Transform3s(p.rotation, p.translation) for p in places.oMg]
        centres = [p.act(h.aabb_center) for p, h in zip(places.oMg, hulls)]
        depths = {}
        for i, j in near_pairs(centres, [h.aabb_radius for h in hulls], bodies):
            result = coal.DistanceResult()
            distance = coal.distance(hulls[i], at[i], hulls[j], at[j], request, result)
            deepest(depths, (first[bodies[i]], first[bodies[j]]), -distance)
        found.append(depths)
    free = pin.buildModelFromUrdf(path, pin.JointModelFreeFlyer())
    data = free.createData()
    pin.crba(free, data, pin.neutral(free))
    pin.ccrba(free, data, pin.neutral(free), np.zeros(free.nv))
    centre = pin.centerOfMass(free, data, pin.neutral(free))
    mass, inertia = pin.computeTotalMass(free), data.Ig.inertia
    return {"depths": found, "mass": mass, "centre": centre.tolist(), "inertia": inertia.flatten().tolist()}


CLIENTS = {"mujoco": mujoco_client, "pinocchio": pinocchio_client}


def ask(client, question):
    command = [sys.executable, __file__, "--one", client]
    done = subprocess.run(command, input=question, capture_output=True, text=True, timeout=600)
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode == 0 and lines:
        return json.loads(lines[-1])
    return {"error": f"exit {done.returncode}: {(done.stderr or done.stdout).strip()[-600:]}"}


def main(arguments):
    if arguments[0] == "--one":
        print(json.dumps(CLIENTS[arguments[1]](json.loads(sys.stdin.read()))))
        return
    with open(arguments[0]) as questions:
        for question in questions:
            for client in CLIENTS:
                file = json.loads(question)["file"]
                answer = {"client": client, "file": file, **ask(client, question)}
                print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
