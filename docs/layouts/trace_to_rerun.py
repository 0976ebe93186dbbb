#!/usr/bin/env python3
"""Turns a trace into a recording for Rerun: links with their surfaces, poses and joints as entities,
pictures, log and verdict beside them, and a layout for all that.

    pip install "rerun-sdk==0.41.*" mcap mcap-protobuf-support
    python3 trace_to_rerun.py photo.kinfold/trace.mcap photo.rrd
    rerun photo.rrd

The motion begins at the start of its own time line, `motion`, in seconds; everything else is shown
at every time. What stands where:

    /world/LINK/...        links in their tree, each in its parent's frame (metres, z up)
    .../LINK/surface       a link's surface
    /joints/NAME           a joint's value over the motion (radians or metres)
    /pictures/...          photo, views, parts
    /log, /verdict         what was said on the way, and what the check found
"""

import json
import sys
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

# Most bytes of a trace that are read: those that kinfold itself reads.
MOST = 1 << 30
TIMELINE = "motion"
LEVELS = {3: "**warning** ", 4: "**error** ", 5: "**fatal** "}


class Tree:
    """Where each frame stands in the tree of frames."""

    def __init__(self):
        self.parents = {}

    def take(self, transforms):
        for one in transforms:
            self.parents[one.child_frame_id] = one.parent_frame_id

    def path(self, frame):
        """The entity of a frame: its parents' names, then its own."""
        names, at = [], frame
        while at in self.parents and at not in names:
            names.append(at)
            at = self.parents[at]
        return ["world", *reversed(names)]


def messages(trace):
    """Each message's topic, log time in nanoseconds, schema and contents, in the order of time."""
    with trace.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        protobuf = [
            channel.topic
            for channel in reader.get_summary().channels.values()
            if channel.message_encoding == "protobuf"
        ]
        for schema, channel, message, decoded in reader.iter_decoded_messages(topics=protobuf):
            yield channel.topic, message.log_time, schema.name, decoded
        for schema, channel, message in reader.iter_messages():
            if channel.topic == "/verdict":
                yield channel.topic, message.log_time, schema.name, json.loads(message.data)


def surfaces(scene, tree):
    for entity in scene.entities:
        for number, model in enumerate(entity.models):
            path = [*tree.path(entity.frame_id), f"surface {number}" if number else "surface"]
            position, turn = model.pose.position, model.pose.orientation
            pose = rr.Transform3D(
                translation=[position.x, position.y, position.z],
                quaternion=[turn.x, turn.y, turn.z, turn.w],
            )
            asset = rr.Asset3D(contents=bytes(model.data), media_type="model/gltf-binary")
            rr.log(path, pose, asset, static=True)


def poses(frames, tree):
    for one in frames.transforms:
        place, turn = one.translation, one.rotation
        pose = rr.Transform3D(
            translation=[place.x, place.y, place.z],
            quaternion=[turn.x, turn.y, turn.z, turn.w],
        )
        rr.log(tree.path(one.child_frame_id), pose)


def verdict(found):
    lines = [f"# {found['tier']}", "", f"{found['profile']}", ""]
    for check in found["checks"]:
        if check["status"] != "pass":
            lines.append(f"- **{check['id']}** {check['status']}: {check['rule']}")
            lines.extend(f"  - {evidence}" for evidence in check["evidence"])
    passed = sum(check["status"] == "pass" for check in found["checks"])
    lines.append(f"\n{passed} of {len(found['checks'])} checks passed.")
    document = rr.TextDocument("\n".join(lines), media_type="text/markdown")
    rr.log("verdict", document, static=True)


def picture(topic, message):
    kind = {"jpeg": "image/jpeg", "webp": "image/webp"}.get(message.format, "image/png")
    encoded = rr.EncodedImage(contents=bytes(message.data), media_type=kind)
    rr.log(["pictures", *topic.strip("/").split("/")], encoded, static=True)


def layout():
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Spatial3DView(origin="/world", name="asset"),
            rrb.Vertical(
                rrb.TimeSeriesView(origin="/joints", name="joints"),
                rrb.Tabs(
                    rrb.TextDocumentView(origin="/verdict", name="verdict"),
                    rrb.TextDocumentView(origin="/log", name="log"),
                    rrb.Spatial2DView(origin="/pictures/asset/parts", name="parts"),
                    rrb.Spatial2DView(origin="/pictures/input/photo", name="photo"),
                ),
                row_shares=[1, 2],
            ),
            column_shares=[3, 2],
        ),
        rrb.TimePanel(timeline=TIMELINE, state="collapsed"),
    )


def convert(trace, out):
    if trace.stat().st_size > MOST:
        sys.exit(f"{trace}: a trace has at most {MOST} bytes, found {trace.stat().st_size}")
    rr.init("kinfold", recording_id=str(trace))
    rr.save(out, default_blueprint=layout())
    rr.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    tree, first, scenes, told = Tree(), None, [], []
    for topic, time, schema, message in messages(trace):
        if schema == "foxglove.FrameTransforms":
            first = time if first is None else first
            rr.set_time(TIMELINE, duration=(time - first) / 1e9)
            tree.take(message.transforms)
            poses(message, tree)
        elif schema == "foxglove.JointStates":
            for joint in message.joints:
                rr.log(["joints", joint.name], rr.Scalars(joint.position))
        elif schema == "foxglove.SceneUpdate":
            scenes.append(message)
        elif schema == "foxglove.CompressedImage":
            picture(topic, message)
        elif schema == "foxglove.Log":
            told.append(LEVELS.get(message.level, "") + message.message)
        elif topic == "/verdict":
            verdict(message)
    # Where a link stands in the tree is known once its frame was seen.
    for scene in scenes:
        surfaces(scene, tree)
    lines = "\n".join(f"- {line}" for line in told) or "Nothing was said."
    rr.log("log", rr.TextDocument(lines, media_type="text/markdown"), static=True)
    rr.disconnect()


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: trace_to_rerun.py TRACE.mcap OUT.rrd")
    convert(Path(sys.argv[1]), sys.argv[2])


if __name__ == "__main__":
    main()
