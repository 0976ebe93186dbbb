"""Loads files with one engine, one after the other: `python loads.py ENGINE FILE ...`.

Prints `loaded FILE` or `refused FILE`. To load is to build the model and to take one step.
"""

import os
import sys
import warnings


def mujoco():
    import mujoco

    def load(path):
        model = mujoco.MjModel.from_xml_path(path)
        mujoco.mj_step(model, mujoco.MjData(model))
    return load


def pybullet():
    import pybullet as pb

    pb.connect(pb.DIRECT)

    def load(path):
        pb.resetSimulation()
        pb.loadURDF(path, useFixedBase=True)
        pb.stepSimulation()
    return load


def drake():
    import logging

    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

    logging.disable(logging.WARNING)

    def load(path):
        builder = DiagramBuilder()
        plant, _ = AddMultibodyPlantSceneGraph(builder, 0.001)
        Parser(plant).AddModels(path)
        plant.Finalize()
        Simulator(builder.Build()).AdvanceTo(0.002)
    return load


def newton():
    import newton

    def load(path):
        builder = newton.ModelBuilder()
        (builder.add_usd if path.endswith(".usda") else builder.add_urdf)(path)
        builder.finalize()
    return load


def isaac():
    import logging
    import tempfile

    import urdf_usd_converter

    logging.disable(logging.WARNING)

    def load(path):
        with tempfile.TemporaryDirectory() as folder:
            urdf_usd_converter.Converter().convert(path, folder + "/out")
    return load


def sapien():
    import sapien

    def load(path):
        scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
        scene.create_urdf_loader().load(path)
        scene.step()
    return load


def rerun():
    import rerun.urdf as ru

    return ru.UrdfTree.from_file_path


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    load = globals()[sys.argv[1]]()
    for path in sys.argv[2:]:
        os.chdir(os.path.dirname(path))
        try:
            load(path)
            print(f"\nloaded {path}", flush=True)
        except Exception as error:  # whatever an engine raises is a refusal
            print(f"\nrefused {path}", flush=True)
            print(f"{path}: {str(error)[:200]}", file=sys.stderr)
