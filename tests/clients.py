"""Loads URDFs in MuJoCo, PyBullet, Pinocchio, Drake and yourdfpy and turns them into USD with
urdf-usd-converter; MJCF in MuJoCo; SDFormat in Drake; configurations for Isaac Lab as Python; USD in usd-core with all its validators and in NVIDIA's; traces
in Python's mcap reader. Clients whose modules this Python lacks are left out.

    clients.py [--only CLIENT] FILE...
                                  one JSON line per file and client, each in a process of its own
    clients.py --one CLIENT FILE  that process: prints one JSON object

What a client is asked: how many joints that move, how many collision shapes; for MuJoCo and USD
the figures of bodies and joints; and for MuJoCo the deepest overlap (metres) between links at rest
and with each joint alone at both limits and half way. `warnings` is what it says besides.
"""

import importlib.util
import json
import os
import re
import subprocess
import sys
import tempfile


def inertia_of(quaternion, moments):
    """The tensor along the body's axes, row by row, of principal moments and axes (w, x, y, z)."""
    import numpy as np

    w, x, y, z = (float(c) for c in quaternion)
    turn = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])
    return (turn @ np.diag([float(m) for m in moments]) @ turn.T).tolist()


def mujoco_client(path):
    import mujoco
    import numpy as np

    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)
    # Visual meshes are geoms too, but touch nothing.
    geoms = [g for g in range(model.ngeom) if model.geom_contype[g] or model.geom_conaffinity[g]]

    def deepest():
        mujoco.mj_forward(model, data)
        worst, pair, fromto = 0.0, None, np.zeros(6)
        for i, a in enumerate(geoms):
            for b in geoms[i + 1:]:
                if model.geom_bodyid[a] == model.geom_bodyid[b]:
                    continue
                gap = np.linalg.norm(data.geom_xpos[a] - data.geom_xpos[b])
                if gap > model.geom_rbound[a] + model.geom_rbound[b]:
                    continue
                distance = mujoco.mj_geomDistance(model, data, a, b, 0.01, fromto)
                if -distance > worst:
                    names = [model.body(model.geom_bodyid[g]).name for g in (a, b)]
                    worst, pair = -distance, names
        return worst, pair

    mujoco.mj_resetData(model, data)
    rest, rest_pair = deepest()
    sweep, sweep_pair = rest, rest_pair
    for j in range(model.njnt):
        low, high = model.jnt_range[j] if model.jnt_limited[j] else (-np.pi, np.pi)
        for q in (low, low / 2, high / 2, high):
            mujoco.mj_resetData(model, data)
            data.qpos[model.jnt_qposadr[j]] = q
            depth, pair = deepest()
            if depth > sweep:
                sweep, sweep_pair = depth, pair + [f"joint {model.joint(j).name} at {q:.4f}"]
    mujoco.mj_resetData(model, data)
    mujoco.mj_forward(model, data)
    contacts = int(data.ncon)
    # Continuous joints without friction to speak of may roll; what has limits must stay.
    held = [model.jnt_qposadr[j] for j in range(model.njnt) if model.jnt_limited[j]]
    while data.time < 1.0:
        mujoco.mj_step(model, data)
    crept = max((abs(float(data.qpos[q])) for q in held), default=0.0)
    bodies = sorted(range(1, model.nbody), key=lambda b: model.body(b).name)
    joints = sorted(range(model.njnt), key=lambda j: model.joint(j).name)
    return {
        "joints": int(model.njnt),
        "shapes": len(geoms),
        "joint_names": [model.joint(j).name for j in joints],
        "body_names": [model.body(b).name for b in bodies],
        "masses": [float(model.body_mass[b]) for b in bodies],
        "inertias": [inertia_of(model.body_iquat[b], model.body_inertia[b]) for b in bodies],
        "ranges": [model.jnt_range[j].tolist() for j in joints],
        "efforts": [float(model.jnt_actfrcrange[j][1]) for j in joints],
        "damping": [float(model.dof_damping[model.jnt_dofadr[j]]) for j in joints],
        "friction_loss": [float(model.dof_frictionloss[model.jnt_dofadr[j]]) for j in joints],
        "motors": int(model.nu),
        "contacts_at_rest": contacts,
        "crept_in_a_second": crept,
        "rest_overlap": rest,
        "rest_pair": rest_pair,
        "sweep_overlap": sweep,
        "sweep_pair": sweep_pair,
    }


def pybullet_client(path):
    import pybullet as p

    p.connect(p.DIRECT)
    flags = p.URDF_USE_SELF_COLLISION | p.URDF_USE_INERTIA_FROM_FILE
    body = p.loadURDF(path, useFixedBase=True, flags=flags)
    kinds = [p.getJointInfo(body, j)[2] for j in range(p.getNumJoints(body))]
    moving = [k for k in kinds if k != p.JOINT_FIXED]
    shapes = sum(len(p.getCollisionShapeData(body, link)) for link in range(-1, len(kinds)))
    return {"joints": len(moving), "shapes": shapes}


def pinocchio_client(path):
    import pinocchio as pin

    model = pin.buildModelFromUrdf(path)
    folder = os.path.dirname(os.path.abspath(path))
    shapes = pin.buildGeomFromUrdf(model, path, pin.GeometryType.COLLISION, package_dirs=[folder])
    return {"joints": model.njoints - 1, "shapes": shapes.ngeoms}


def drake_client(path):
    from pydrake.geometry import Role
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    plant, scene = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.001)
    Parser(plant).AddModels(path)
    plant.Finalize()
    joints = [plant.get_joint(j) for j in plant.GetJointIndices()]
    shapes = scene.model_inspector().NumGeometriesWithRole(Role.kProximity)
    own = {i for j in joints for i in plant.GetBodyIndices(j.model_instance())} - {plant.world_body().index()}
    bodies = [plant.get_body(b) for b in own]
    return {
        "joints": sum(j.num_positions() == 1 for j in joints), "shapes": shapes,
        "actuators": plant.num_actuators(),
        "masses": [b.default_mass() for b in sorted(bodies, key=lambda b: b.name())],
    }


def python_client(path):
    """Joints that each actuator group of an Isaac Lab configuration names, by configuration."""
    import ast

    with open(path) as file:
        module = ast.parse(file.read())
    groups = {}
    for statement in module.body:
        if isinstance(statement, ast.Assign) and statement.targets[0].id.endswith("_CFG"):
            fields = {k.arg: k.value for k in statement.value.keywords}
            named = [key.value for key in fields["actuators"].keys]
            groups[statement.targets[0].id] = named
    return {"groups": groups}


def yourdfpy_client(path):
    from yourdfpy import URDF

    loading = {"load_collision_meshes": True, "build_collision_scene_graph": True}
    asset = URDF.load(path, force_collision_mesh=False, **loading)
    if not asset.validate():
        return {"error": "yourdfpy finds it invalid"}
    return {"joints": len(asset.actuated_joints), "shapes": len(asset.collision_scene.geometry)}


def converter_client(path):
    from pxr import Usd, UsdPhysics
    from urdf_usd_converter import Converter

    with tempfile.TemporaryDirectory() as folder:
        stage = Usd.Stage.Open(Converter().convert(path, folder).path)
        prims = list(stage.Traverse(Usd.TraverseInstanceProxies()))
    shapes = [p for p in prims if p.HasAPI(UsdPhysics.CollisionAPI)]
    joints = [p for p in prims if p.IsA(UsdPhysics.RevoluteJoint) or p.IsA(UsdPhysics.PrismaticJoint)]
    return {"joints": len(joints), "shapes": len(shapes)}


def nvidia_client(path):
    """NVIDIA's validator with its default rules, on the same stage in binary form."""
    from pxr import Usd
    from usd_validation_nvidia import ValidationEngine

    with tempfile.TemporaryDirectory() as folder:
        binary = os.path.join(folder, "asset.usdc")
        Usd.Stage.Open(path).Export(binary)
        engine = ValidationEngine()
        issues = list(engine.validate(binary).issues())
    told = [f"{i.severity.name} {i.rule.__name__ if i.rule else '-'}: {i.message}" for i in issues]
    return {"findings": told}


def mcap_client(path):
    from mcap.reader import make_reader
    from mcap_protobuf.decoder import DecoderFactory

    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        stages, topics = [], {}
        for schema, channel, message in reader.iter_messages():
            topics[channel.topic] = topics.get(channel.topic, 0) + 1
            if channel.topic == "/stage":
                event = json.loads(message.data)
                if event["event"] == "finished":
                    stages.append(event["stage"])
        for _ in reader.iter_decoded_messages(topics=[t for t in topics if t.startswith("/view")]):
            pass
        attachments = [a.name for a in reader.iter_attachments()]
    return {"stages": stages, "topics": topics, "attachments": attachments}


def usd_client(path):
    """Every validator of usd-core on the stage; figures by name of link and joint, as MuJoCo's."""
    import math

    from pxr import Usd, UsdGeom, UsdPhysics, UsdValidation

    stage = Usd.Stage.Open(path)
    registry = UsdValidation.ValidationRegistry()
    validators = registry.GetOrLoadAllValidators()
    context = UsdValidation.ValidationContext(validators)
    findings = [f"{e.GetName()}: {e.GetMessage()}" for e in context.Validate(stage)]
    prims = list(stage.Traverse())
    prims.sort(key=lambda prim: prim.GetName())
    links = [p for p in prims if p.HasAPI(UsdPhysics.RigidBodyAPI)]
    masses = [UsdPhysics.MassAPI(p) for p in links]
    shapes = [p for p in prims if p.HasAPI(UsdPhysics.CollisionAPI)]
    joints = [p for p in prims if p.IsA(UsdPhysics.RevoluteJoint) or p.IsA(UsdPhysics.PrismaticJoint)]

    def quaternion(q):
        return [q.GetReal(), *q.GetImaginary()]

    def limits(prim):
        kind = UsdPhysics.RevoluteJoint if prim.IsA(UsdPhysics.RevoluteJoint) else UsdPhysics.PrismaticJoint
        ends = [kind(prim).GetLowerLimitAttr().Get(), kind(prim).GetUpperLimitAttr().Get()]
        if not all(math.isfinite(e) for e in ends):
            return [0.0, 0.0]
        return [math.radians(e) for e in ends] if kind is UsdPhysics.RevoluteJoint else ends

    def effort(prim):
        name = "angular" if prim.IsA(UsdPhysics.RevoluteJoint) else "linear"
        return UsdPhysics.DriveAPI(prim, name).GetMaxForceAttr().Get()

    return {
        "validators": len(validators),
        "findings": findings,
        "up_axis": str(UsdGeom.GetStageUpAxis(stage)),
        "metres_per_unit": UsdGeom.GetStageMetersPerUnit(stage),
        "joints": len(joints),
        "shapes": len(shapes),
        "joint_names": [p.GetName() for p in joints],
        "masses": [m.GetMassAttr().Get() for m in masses],
        "inertias": [
            inertia_of(quaternion(m.GetPrincipalAxesAttr().Get()), m.GetDiagonalInertiaAttr().Get())
            for m in masses
        ],
        "ranges": [limits(p) for p in joints],
        "efforts": [effort(p) for p in joints],
    }


CLIENTS = {
    ".urdf": {
        "mujoco": mujoco_client,
        "pybullet": pybullet_client,
        "pinocchio": pinocchio_client,
        "drake": drake_client,
        "yourdfpy": yourdfpy_client,
        "converter": converter_client,
    },
    ".xml": {"mujoco": mujoco_client},
    ".sdf": {"drake": drake_client},
    ".py": {"python": python_client},
    ".usda": {"usd": usd_client, "nvidia": nvidia_client},
    ".mcap": {"mcap": mcap_client},
}
MODULES = {
    "python": "ast",
    "drake": "pydrake",
    "converter": "urdf_usd_converter",
    "nvidia": "usd_validation_nvidia",
    "usd": "pxr.UsdValidation",
}


def is_here(client):
    module = MODULES.get(client, client)
    try:
        return importlib.util.find_spec(module) is not None
    except ModuleNotFoundError:
        return False


def clients_for(path):
    of_kind = CLIENTS[os.path.splitext(path)[1]]
    return {name: client for name, client in of_kind.items() if is_here(name)}


def run(client, path):
    command = [sys.executable, __file__, "--one", client, path]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    lines = done.stdout.splitlines()
    answers = [line for line in lines if line.startswith("{")]
    told = [line for line in lines if line not in answers] + done.stderr.splitlines()
    warnings = [line for line in told if re.search("warn|error|fail", line, re.IGNORECASE)]
    if done.returncode == 0 and answers:
        return {**json.loads(answers[-1]), "warnings": warnings}
    return {"error": f"exit {done.returncode}: {(done.stderr or done.stdout).strip()[-400:]}"}


def main(arguments):
    if arguments[:1] == ["--one"]:
        _, client, path = arguments
        print(json.dumps(clients_for(path)[client](path)))
        return
    only = arguments[1] if arguments[:1] == ["--only"] else None
    for path in arguments[2:] if only else arguments:
        for client in clients_for(path):
            if only not in (None, client):
                continue
            print(json.dumps({"file": path, "client": client, **run(client, path)}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
