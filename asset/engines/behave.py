"""What engines do with assets: whether joints stay where they rest, and reach both limits.

    behave.py [--engines NAME,NAME] FOLDER...    one JSON line per engine and asset, then a table
    behave.py --one ENGINE FOLDER...             that process: one JSON line per asset

A folder has `asset.urdf` and, for the engines that read them, `asset.xml` and `asset.usda`.
`cargo run -p kinfold-asset --example write_formats` writes such folders. The root is held. An asset hangs for 5 s in
gravity and nothing drives it; then each joint is pushed with its declared effort, which grows for
1.5 s and is held for 1.5 s, towards one limit and the other. A joint stays if it never moved more
than 0.02 rad or 1 % of its range; it reaches a limit if it ends within 1 % of its range of it. An
engine that this Python lacks is left out: forecast/engines/requirements.txt and, for Newton, a folder of
its own with newton[sim]==1.8.0.
"""

import contextlib
import io
import json
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as tree

REST, RAMP, PUSH = 5.0, 1.5, 3.0
NEAR, STILL = 0.01, 0.02


def read(folder):
    """Joints that move, as the URDF has them."""
    joints = {}
    for joint in tree.parse(os.path.join(folder, "asset.urdf")).getroot().findall("joint"):
        if joint.get("type") == "fixed":
            continue
        limit, dynamics = joint.find("limit"), joint.find("dynamics")
        ends = [float(limit.get(k)) for k in ("lower", "upper")] if limit.get("lower") else None
        joints[joint.get("name")] = {
            "kind": joint.get("type"), "ends": ends, "effort": float(limit.get("effort")),
            "friction": float(dynamics.get("friction")),
        }
    return joints


class Mujoco:
    def __init__(self, folder, file):
        import mujoco

        self.of = mujoco
        self.model = mujoco.MjModel.from_xml_path(os.path.join(folder, file))
        self.data = mujoco.MjData(self.model)
        self.step_s = self.model.opt.timestep
        self.at = {self.model.joint(j).name: j for j in range(self.model.njnt)}

    def reset(self):
        self.of.mj_resetData(self.model, self.data)

    def step(self, forces):
        self.data.qfrc_applied[:] = 0
        for name, force in forces.items():
            self.data.qfrc_applied[self.model.jnt_dofadr[self.at[name]]] = force
        self.of.mj_step(self.model, self.data)

    def values(self):
        return {name: float(self.data.qpos[self.model.jnt_qposadr[j]]) for name, j in self.at.items()}

    def more(self):
        self.reset()
        self.of.mj_forward(self.model, self.data)
        pull = {n: float(self.data.qfrc_bias[self.model.jnt_dofadr[j]]) for n, j in self.at.items()}
        return {"pull": pull, "actuators": self.model.nu}


class Pybullet:
    step_s = 1 / 240

    def __init__(self, folder, file):
        import pybullet as pb

        self.of = pb
        pb.connect(pb.DIRECT)
        self.file = os.path.join(os.path.abspath(folder), file)
        self.reset()

    def reset(self):
        pb = self.of
        pb.resetSimulation()
        pb.setGravity(0, 0, -9.81)
        flags = pb.URDF_USE_INERTIA_FROM_FILE
        self.body = pb.loadURDF(self.file, useFixedBase=True, flags=flags)
        self.at = {}
        for j in range(pb.getNumJoints(self.body)):
            info = pb.getJointInfo(self.body, j)
            if info[2] in (pb.JOINT_REVOLUTE, pb.JOINT_PRISMATIC):
                self.at[info[1].decode()] = j
                pb.setJointMotorControl2(self.body, j, pb.VELOCITY_CONTROL, force=0)

    def step(self, forces):
        for name, force in forces.items():
            self.of.setJointMotorControl2(self.body, self.at[name], self.of.TORQUE_CONTROL, force=force)
        self.of.stepSimulation()

    def values(self):
        return {name: self.of.getJointState(self.body, j)[0] for name, j in self.at.items()}

    def more(self):
        return {}


class Drake:
    step_s = 0.002

    def __init__(self, folder, file):
        import logging

        import numpy as np
        from pydrake.multibody.parsing import Parser
        from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
        from pydrake.multibody.tree import JointIndex
        from pydrake.systems.analysis import Simulator
        from pydrake.systems.framework import DiagramBuilder

        logging.getLogger("drake").setLevel(logging.ERROR)
        self.np, self.simulator_of = np, Simulator
        builder = DiagramBuilder()
        self.plant, _ = AddMultibodyPlantSceneGraph(builder, self.step_s)
        Parser(self.plant).AddModels(os.path.join(folder, file))
        root = tree.parse(os.path.join(folder, "asset.urdf")).getroot().find("link").get("name")
        self.plant.WeldFrames(self.plant.world_frame(), self.plant.GetFrameByName(root))
        self.plant.Finalize()
        self.diagram = builder.Build()
        joints = [self.plant.get_joint(JointIndex(j)) for j in range(self.plant.num_joints())]
        self.at = {j.name(): j for j in joints if j.num_velocities() == 1}
        self.reset()

    def reset(self):
        self.simulator = self.simulator_of(self.diagram)
        self.context = self.plant.GetMyContextFromRoot(self.simulator.get_mutable_context())
        self.t = 0.0
        if self.plant.num_actuators():
            port = self.plant.get_actuation_input_port()
            port.FixValue(self.context, self.np.zeros(self.plant.num_actuators()))

    def step(self, forces):
        push = self.np.zeros(self.plant.num_velocities())
        for name, force in forces.items():
            push[self.at[name].velocity_start()] = force
        self.plant.get_applied_generalized_force_input_port().FixValue(self.context, push)
        self.t += self.step_s
        self.simulator.AdvanceTo(self.t)

    def values(self):
        q = self.plant.GetPositions(self.context)
        return {name: float(q[j.position_start()]) for name, j in self.at.items()}

    def more(self):
        return {"actuators": self.plant.num_actuators()}


class Sapien:
    step_s = 0.002

    def __init__(self, folder, file):
        import numpy as np
        import sapien
        from sapien import physx

        self.np = np
        root = tree.parse(os.path.join(folder, file)).getroot()
        for link in root.findall("link"):
            for visual in link.findall("visual"):
                link.remove(visual)
        copy = os.path.join(folder, ".behave.urdf")
        tree.ElementTree(root).write(copy)
        try:
            self.scene = sapien.Scene([physx.PhysxCpuSystem()])
            self.scene.set_timestep(self.step_s)
            loader = self.scene.create_urdf_loader()
            loader.fix_root_link = True
            self.robot = loader.load(copy)
        finally:
            os.remove(copy)
        self.at = {j.name: i for i, j in enumerate(self.robot.active_joints)}

    def reset(self):
        zero = self.np.zeros(len(self.at))
        self.robot.set_qpos(zero)
        self.robot.set_qvel(zero)

    def step(self, forces):
        push = self.np.zeros(len(self.at))
        for name, force in forces.items():
            push[self.at[name]] = force
        self.robot.set_qf(push)
        self.scene.step()

    def values(self):
        q = self.robot.get_qpos()
        return {name: float(q[i]) for name, i in self.at.items()}

    def more(self):
        return {}


class Newton:
    step_s = 0.002

    def __init__(self, folder, file):
        with contextlib.redirect_stdout(io.StringIO()):
            import warp as wp

            wp.config.quiet = True
            import newton
        self.of = newton
        builder = newton.ModelBuilder()
        newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
        path = os.path.join(folder, file)
        if file.endswith(".usda"):
            # The root of our USD is free: whoever wants it held joins it to the world.
            with open(path) as layer:
                text = layer.read()
            root = re.search(r'def Xform "Links"\s*\{\s*def Xform "(\w+)"', text).group(1)
            name = re.search(r'defaultPrim = "(\w+)"', text).group(1)
            held = f'def PhysicsFixedJoint "held" {{\n rel physics:body1 = </{name}/Links/{root}>\n }}\n'
            head = re.search(r'def Scope "Joints"\s*\{\n', text).end()
            copy = os.path.join(folder, ".behave.usda")
            with open(copy, "w") as layer:
                layer.write(text[:head] + held + text[head:])
            try:
                builder.add_usd(copy)
            finally:
                os.remove(copy)
        else:
            builder.add_urdf(path, floating=False)
        self.names = [label.rsplit("/", 1)[-1] for label in builder.joint_label]
        self.at = {n: builder.joint_qd_start[j] for j, n in enumerate(self.names)
                   if builder.joint_type[j] in (newton.JointType.REVOLUTE, newton.JointType.PRISMATIC)}
        self.q_at = {n: builder.joint_q_start[j] for j, n in enumerate(self.names) if n in self.at}
        self.model = builder.finalize(device="cpu")
        self.solver = newton.solvers.SolverMuJoCo(self.model, use_mujoco_cpu=True)
        self.reset()

    def reset(self):
        self.state, self.next = self.model.state(), self.model.state()
        self.control = self.model.control()
        self.of.eval_fk(self.model, self.model.joint_q, self.model.joint_qd, self.state)
        self.solver.reset(self.state) if hasattr(self.solver, "reset") else None

    def step(self, forces):
        push = self.control.joint_f.numpy()
        push[:] = 0
        for name, force in forces.items():
            push[self.at[name]] = force
        self.control.joint_f.assign(push)
        self.solver.step(self.state, self.next, self.control, None, self.step_s)
        self.state, self.next = self.next, self.state

    def values(self):
        q = self.state.joint_q.numpy()
        return {name: float(q[i]) for name, i in self.q_at.items()}

    def more(self):
        friction = self.model.joint_friction.numpy()
        return {"friction": {n: float(friction[i]) for n, i in self.at.items()}}


ENGINES = {
    "mujoco-mjcf": (Mujoco, "mujoco", "asset.xml"),
    "mujoco-urdf": (Mujoco, "mujoco", "asset.urdf"),
    "pybullet-urdf": (Pybullet, "pybullet", "asset.urdf"),
    "drake-urdf": (Drake, "pydrake", "asset.urdf"),
    "drake-sdf": (Drake, "pydrake", "asset.sdf"),
    "sapien-urdf": (Sapien, "sapien", "asset.urdf"),
    "newton-urdf": (Newton, "newton, mujoco_warp", "asset.urdf"),
    "newton-usd": (Newton, "newton, mujoco_warp, pxr", "asset.usda"),
}


def stays(engine, joints):
    """The farthest that each joint went from its rest in 5 s."""
    engine.reset()
    farthest = dict.fromkeys(joints, 0.0)
    steps = round(REST / engine.step_s)
    for i in range(steps):
        engine.step({})
        if i % 10 == 0 or i == steps - 1:
            for name, value in engine.values().items():
                farthest[name] = max(farthest.get(name, 0.0), abs(value))
    return farthest


def pushed(engine, name, effort):
    """Where a joint is after its effort has pushed it."""
    engine.reset()
    steps = round(PUSH / engine.step_s)
    for i in range(steps):
        engine.step({name: effort * min(1.0, i * engine.step_s / RAMP)})
    return engine.values()[name]


def ask(engine_name, folder):
    kind, _, file = ENGINES[engine_name]
    joints = read(folder)
    engine = kind(folder, file)
    answer = {"engine": engine_name, "asset": os.path.basename(os.path.abspath(folder)), **engine.more()}
    known = engine.values()
    answer["missing"] = sorted(set(joints) - set(known))
    joints = {n: j for n, j in joints.items() if n in known}
    moved = stays(engine, joints)
    answer["joints"] = {}
    for name, joint in joints.items():
        low, high = (pushed(engine, name, way * joint["effort"]) for way in (-1, 1))
        answer["joints"][name] = {**joint, "moved": moved[name], "low": low, "high": high}
    return answer


def holds(joint):
    span = joint["ends"][1] - joint["ends"][0] if joint["ends"] else 6.28
    turns = joint["kind"] != "prismatic"
    return joint["moved"] <= max(STILL if turns else 0.0, NEAR * span)


def reaches(joint):
    if not joint["ends"]:
        return min(-joint["low"], joint["high"]) > 0.5
    near = NEAR * (joint["ends"][1] - joint["ends"][0])
    return all(abs(joint[k] - end) <= near for k, end in zip(("low", "high"), joint["ends"]))


def table(answers):
    """A line per engine: assets, joints, how many stay and reach both limits; pulled ones apart."""
    pulls = {}
    for a in answers:
        if "pull" in a and a["engine"] == "mujoco-mjcf":
            pulls[a["asset"]] = a["pull"]
    print(f"{'engine':14} assets failed joints missing stay% (unpulled% pulled%) reach%")
    for name in ENGINES:
        of = [a for a in answers if a["engine"] == name]
        if not of:
            continue
        good = [a for a in of if "error" not in a]
        every = [(a["asset"], n, j) for a in good for n, j in a["joints"].items()]

        def is_pulled(asset, n, j):
            return abs(pulls.get(asset, {}).get(n, 0.0)) > 1e-3 * j["effort"]

        def share(some, what):
            return f"{100 * sum(map(what, some)) / len(some):.1f}" if some else "-"

        pulled = [j for a, n, j in every if is_pulled(a, n, j)]
        rest = [j for a, n, j in every if not is_pulled(a, n, j)]
        all_of = pulled + rest
        missing = sum(len(a["missing"]) for a in good)
        print(f"{name:14} {len(of):6} {len(of) - len(good):6} {len(all_of):6} {missing:7} "
              f"{share(all_of, holds):>5} ({share(rest, holds)} {share(pulled, holds)}) {share(all_of, reaches)}")


def main(arguments):
    if arguments[:1] == ["--one"]:
        for folder in arguments[2:]:
            try:
                answer = ask(arguments[1], folder)
            except Exception as error:  # every kind: one asset must not hide the rest
                asset = os.path.basename(os.path.abspath(folder))
                answer = {"engine": arguments[1], "asset": asset, "error": f"{type(error).__name__}: {error}"}
            print("\n" + json.dumps(answer), flush=True)
        return
    names = list(ENGINES)
    if arguments[:1] == ["--engines"]:
        names, arguments = arguments[1].split(","), arguments[2:]
    answers = []
    for name in names:
        folders = [f for f in arguments if os.path.isfile(os.path.join(f, ENGINES[name][2]))]
        here = subprocess.run([sys.executable, "-c", f"import {ENGINES[name][1]}"], capture_output=True)
        if here.returncode or not folders:
            print(f"SKIPPED {name}: no {ENGINES[name][1]} here, or no {ENGINES[name][2]}", file=sys.stderr)
            continue
        for folder in folders:
            command = [sys.executable, __file__, "--one", name, folder]
            done = subprocess.run(command, capture_output=True, text=True)
            lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
            gone = {"engine": name, "asset": os.path.basename(os.path.abspath(folder)),
                    "error": f"exit {done.returncode}: {done.stderr[-300:]}"}
            answers.append(json.loads(lines[-1]) if lines else gone)
            print(json.dumps(answers[-1]), flush=True)
    table(answers)


if __name__ == "__main__":
    main(sys.argv[1:])
