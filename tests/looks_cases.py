"""Twenty-two textured cabinets, each with one peculiarity of mesh files, made into assets and compared with
what their files show. Outside of CI: it needs `pip install mujoco usd-core trimesh scipy pillow numpy` and,
for pictures, `MUJOCO_GL=egl` or `osmesa`.

    python tests/looks_cases.py KINFOLD FOLDER [NAME...]

Prints for each case how far the mean colour of GLB, URDF and USD lies off, in steps of 255, where the file has
a surface, and leaves `sheet.png` in the folder: MuJoCo's pictures, URDF's meshes in MJCF, a row for a case.
"""

import io
import json
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).parent))
import looks

BODY, LID = ((-0.2, 0.0, -0.15), (0.2, 0.3, 0.15)), ((-0.2, 0.302, -0.15), (0.2, 0.33, 0.15))
QUADS = [(0, 2, 6, 4), (1, 5, 7, 3), (0, 4, 5, 1), (2, 3, 7, 6), (0, 1, 3, 2), (4, 6, 7, 5)]


def box(low, high):
    """Twenty-four corners, y up, and twelve faces that look outward; a side has a sixth of the picture."""
    points, places, faces = [], [], []
    for side, quad in enumerate(QUADS):
        column, row = side % 3, side // 3
        for n, corner in enumerate(quad):
            points.append([(high if corner >> (2 - k) & 1 else low)[k] for k in range(3)])
            u, v = (column + (0.06 if n in (0, 3) else 0.94)) / 3, (row + (0.06 if n in (0, 1) else 0.94)) / 2
            places.append([u, v])
        first = 4 * side
        faces += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    return np.array(points), np.array(places), np.array(faces)


def picture(seed, size=96):
    """Six fields of different colours with stripes, so that a turn or a swap is seen."""
    random = np.random.default_rng(seed)
    pixels = np.zeros((size, size, 3), np.uint8)
    for side in range(6):
        x, y = side % 3 * size // 3, side // 3 * size // 2
        field = pixels[y : y + size // 2, x : x + size // 3]
        field[:] = random.integers(40, 230, 3)
        field[:, : 4 + 2 * side] = field[0, -1] // 2
        field[: size // 8] = 255 - field[-1, -1] // 2
    return pixels


def encoded(pixels, kind="PNG", **more):
    out = io.BytesIO()
    (pixels if isinstance(pixels, Image.Image) else Image.fromarray(pixels)).save(out, kind, **more)
    return out.getvalue()


class Glb:
    """A GLB in the making."""

    def __init__(self):
        self.bytes, self.json = b"", {"asset": {"version": "2.0"}, "accessors": [], "bufferViews": []}

    def view(self, data):
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        self.bytes += data
        return len(self.json["bufferViews"]) - 1

    def rows(self, rows, shape):
        kind = 5125 if shape == "SCALAR" else 5126
        rows = np.asarray(rows, np.uint32 if kind == 5125 else np.float32)
        accessor = {"bufferView": self.view(rows.tobytes()), "componentType": kind, "count": len(rows), "type": shape}
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def texture(self, data, sampler=None):
        for name in ("images", "textures", "samplers"):
            self.json.setdefault(name, [])
        self.json["images"].append({"bufferView": self.view(data), "mimeType": "image/png"})
        self.json["samplers"].append(sampler or {})
        last = len(self.json["images"]) - 1
        self.json["textures"].append({"source": last, "sampler": last})
        return last

    def finish(self):
        self.json["buffers"] = [{"byteLength": len(self.bytes)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        data = self.bytes + b"\0" * (-len(self.bytes) % 4)
        head = struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(data))
        chunk = lambda kind, body: struct.pack("<I", len(body)) + kind + body
        return head + chunk(b"JSON", text) + chunk(b"BIN\0", data)


class Part:
    """What a box shows: its corners, and for each point of it a colour."""

    def __init__(self, which, seed):
        self.points, self.places, self.faces = box(*which)
        self.pixels, self.factor, self.tints = picture(seed), np.ones(4), np.ones((24, 4))
        self.move, self.wrap, self.sets, self.encode = {}, {}, 0, lambda p: encoded(p)
        self.mode, self.more, self.bare, self.turned = None, {}, False, None


def linear(c):
    c = np.asarray(c, float)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def display(c):
    c = np.clip(c, 0, 1)
    return np.where(c <= 0.0031308, c * 12.92, 1.055 * c ** (1 / 2.4) - 0.055)


def moved(part, uv):
    """Coordinates after the texture transform."""
    scale, turn = part.move.get("scale", [1, 1]), part.move.get("rotation", 0)
    u, v = uv[:, 0] * scale[0], uv[:, 1] * scale[1]
    cos, sin, offset = np.cos(turn), np.sin(turn), part.move.get("offset", [0, 0])
    return np.stack([cos * u + sin * v + offset[0], cos * v - sin * u + offset[1]], 1)


def due(part, count=20_000):
    """Points over a box, in its file's place, and the colours they have there, 0 to 255."""
    random = np.random.default_rng(1)
    corners = part.points[part.faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    face = random.choice(len(area), count, p=area / area.sum())
    a, b = random.random((2, count))
    over = a + b > 1
    a[over], b[over] = 1 - a[over], 1 - b[over]
    shares = np.stack([1 - a - b, a, b], 1)
    of = lambda rows: (rows[part.faces[face]] * shares[:, :, None]).sum(1)
    colours = np.ones((count, 3))
    if not part.bare:
        height, width = part.pixels.shape[:2]
        uv = moved(part, of(part.places))
        wrap = lambda c, mode: {33071: c.clip(0, 1 - 1e-9), 33648: 1 - abs(c % 2 - 1)}.get(mode, c % 1)
        x = (wrap(uv[:, 0], part.wrap.get("wrapS")) * width).astype(int).clip(0, width - 1)
        y = (wrap(uv[:, 1], part.wrap.get("wrapT")) * height).astype(int).clip(0, height - 1)
        colours = linear(part.pixels[y, x, :3] / 255)
    return of(part.points), 255 * display(colours * part.factor[:3] * of(part.tints)[:, :3])


def glb(parts, edit=lambda file: None):
    file = Glb()
    file.json["materials"], primitives = [], []
    for n, part in enumerate(parts):
        info = {"index": file.texture(part.encode(part.pixels), part.wrap), "texCoord": part.sets} if not part.bare else None
        if info and part.move:
            info["extensions"] = {"KHR_texture_transform": part.move}
        pbr = {"baseColorFactor": list(part.factor), "metallicFactor": 0}
        pbr.update({"baseColorTexture": info} if info else {})
        file.json["materials"].append({"name": f"m{n}", "pbrMetallicRoughness": pbr, **part.more})
        attributes = {"POSITION": file.rows(part.points, "VEC3")}
        for own in range(part.sets + 1):
            rows = part.places if own == part.sets else part.places * 0.3
            attributes[f"TEXCOORD_{own}"] = file.rows(rows, "VEC2")
        if (part.tints != 1).any():
            attributes["COLOR_0"] = file.rows(part.tints, "VEC4")
        primitives.append({"attributes": attributes, "indices": file.rows(part.faces.ravel(), "SCALAR"), "material": n})
    file.json.update(meshes=[{"primitives": primitives}], nodes=[{"mesh": 0}], scenes=[{"nodes": [0]}], scene=0)
    edit(file)
    return file.finish()


def obj(parts, folder):
    text, mtl, first = "mtllib case.mtl\n", "", 1
    for n, part in enumerate(parts):
        (folder / f"picture {n}.png").write_bytes(encoded(part.pixels))
        mtl += f"newmtl m{n}\nKd 1 1 1\nmap_Kd picture {n}.png\n"
        text += "".join(f"v {x} {y} {z}\n" for x, y, z in part.points)
        text += "".join(f"vt {u} {1 - v}\n" for u, v in part.places) + f"usemtl m{n}\n"
        text += "".join("f " + " ".join(f"{first + i}/{first + i}" for i in face) + "\n" for face in part.faces)
        first += len(part.points)
    (folder / "case.mtl").write_text(mtl)
    (folder / "case.obj").write_text(text)
    return folder / "case.obj"


def usdz(parts, folder):
    from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdUtils

    stage = Usd.Stage.CreateNew(str(folder / "case.usdc"))
    UsdGeom.SetStageUpAxis(stage, "Y")
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    for n, part in enumerate(parts):
        (folder / f"picture_{n}.png").write_bytes(encoded(part.pixels))
        mesh = UsdGeom.Mesh.Define(stage, f"/part{n}")
        mesh.CreatePointsAttr([Gf.Vec3f(*(100 * p)) for p in part.points])
        mesh.CreateFaceVertexCountsAttr([3] * len(part.faces))
        mesh.CreateFaceVertexIndicesAttr([int(i) for i in part.faces.ravel()])
        mesh.CreateSubdivisionSchemeAttr("none")
        kind = Sdf.ValueTypeNames.TexCoord2fArray
        places = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("UVMap", kind, "vertex")
        places.Set([Gf.Vec2f(u, 1 - v) for u, v in part.places])
        shader = lambda name, kind: (s := UsdShade.Shader.Define(stage, f"/m{n}/{name}"), s.CreateIdAttr(kind))[0]
        material = UsdShade.Material.Define(stage, f"/m{n}")
        surface, texture = shader("s", "UsdPreviewSurface"), shader("t", "UsdUVTexture")
        reader = shader("r", "UsdPrimvarReader_float2")
        material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(f"./picture_{n}.png")
        texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
        reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("UVMap")
        colour = surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
        colour.ConnectToSource(texture.ConnectableAPI(), "rgb")
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
    stage.GetRootLayer().Save()
    UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(folder / "case.usdc")), str(folder / "case.usdz"))
    return folder / "case.usdz"


def ply(parts, folder):
    colours = np.vstack([255 * display(p.tints[:, :3]) for p in parts]).round().astype(int)
    points = np.vstack([p.points for p in parts])
    faces = np.vstack([p.faces + 24 * n for n, p in enumerate(parts)])
    names = [f"property float {c}" for c in "xyz"] + [f"property uchar {c}" for c in ("red", "green", "blue")]
    head = ["ply", "format ascii 1.0", f"element vertex {len(points)}", *names]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    rows = [" ".join(map(str, [*p, *c])) for p, c in zip(points, colours)]
    (folder / "case.ply").write_text("\n".join(head + rows + ["3 " + " ".join(map(str, f)) for f in faces]) + "\n")
    return folder / "case.ply"


def cases():
    """Name, and what makes its file: parts with their peculiarity, and a writer."""

    def case(name, edit=lambda part: None, writer=None, file=lambda file: None):
        parts = [Part(BODY, 1), Part(LID, 2)]
        for part in parts:
            edit(part)
        yield_ = writer or (lambda parts, folder: written(folder, glb(parts, file)))
        return name, parts, yield_

    def written(folder, data):
        (folder / "case.glb").write_bytes(data)
        return folder / "case.glb"

    def set_(**values):
        return lambda part: [setattr(part, name, value) for name, value in values.items()]

    def corners(part):
        part.tints = np.ones((24, 4))
        part.tints[:, :3] = np.where(np.arange(24)[:, None] % 4 < 2, [1.0, 0.25, 0.25], [0.5, 1.0, 0.3])

    def sides(part):
        part.bare, part.tints = True, np.ones((24, 4))
        part.tints[:, :3] = linear(np.repeat([[230, 40, 40], [40, 200, 40], [40, 40, 220]] * 2, 4, 0) / 255)

    def alone(part):
        part.pixels = np.dstack([part.pixels, np.full(part.pixels.shape[:2], 255, np.uint8)])
        part.pixels[::7, :, 3] = 255

    def grey(part):
        part.pixels = np.repeat(part.pixels.mean(2, keepdims=True).astype(np.uint8), 3, 2)
        part.encode = lambda p: encoded(p[:, :, 0])

    def palette(part):
        image = Image.fromarray(part.pixels).quantize(16)
        part.pixels = np.asarray(image.convert("RGB"))
        part.encode = lambda p: encoded(image)

    def jpeg(part):
        data = encoded(part.pixels, "JPEG", quality=95)
        part.pixels, part.encode = np.asarray(Image.open(io.BytesIO(data))), lambda p: data

    def webp(part):
        part.encode = lambda p: encoded(p, "WEBP", lossless=True)

    def mirrored(part):
        part.places = np.column_stack([1 - part.places[:, 0], part.places[:, 1]])

    def several(part):
        part.factor = np.array([1.0, 0.5, 0.5, 1.0]) if part.points[0, 1] > 0.3 else np.ones(4)

    def scaled(file):
        file.json["nodes"] = [{"mesh": 0, "scale": [-1, 1, 1]}]

    def buried(file):
        file.json["nodes"] = [{"children": [1], "translation": [0, 0, 1]}, {"mesh": 0, "rotation": [0, 0.7071068, 0, 0.7071068]}]

    turn = {"rotation": 0.5, "scale": [0.8, 0.7], "offset": [0.1, 0.3]}
    clamp, mirror = {"wrapS": 33071, "wrapT": 33071}, {"wrapS": 33648, "wrapT": 33648}
    return [
        case("plain"),
        case("factor over the picture", set_(factor=np.array([0.5, 0.25, 1.0, 1.0]))),
        case("transform", set_(move=turn)),
        case("tiled", set_(move={"scale": [4, 3]})),
        case("mirrored repeat", set_(move={"scale": [2, 2]}, wrap=mirror)),
        case("clamped", set_(move={"scale": [1.4, 1.4], "offset": [-0.2, -0.2]}, wrap=clamp)),
        case("mirrored coordinates", mirrored),
        case("second set", set_(sets=1)),
        case("one tint", set_(tints=np.tile([0.5, 1.0, 0.25, 1.0], (24, 1)))),
        case("tints by corner", corners),
        case("colours alone", sides),
        case("mask", lambda p: (alone(p), setattr(p, "more", {"alphaMode": "MASK", "alphaCutoff": 0.5}))),
        case("opaque with opacity", lambda p: alone(p)),
        case("two materials", several),
        case("grey picture", grey),
        case("palette", palette),
        case("jpeg", jpeg),
        case("webp", webp),
        case("mirroring node", file=scaled),
        case("turned nodes", file=buried),
        case("obj with mtl", writer=obj),
        case("usdz", writer=usdz),
        case("ply colours", sides, writer=ply),
    ]


CONDITION = {
    "schema": "kinfold-condition/1", "category": "box", "size": {"height": 0.33},
    "parts": [
        {"name": "body", "text": "box body", "material": "wood"},
        {"name": "lid", "text": "box lid", "parent": "body", "joint": "revolute", "material": "wood"},
    ],
}


def of_usd(path):
    """Surfaces of a USD layer with the colours of its own textures, for [`looks.spread`]."""
    import trimesh
    from pxr import Usd, UsdGeom, UsdShade

    stage = Usd.Stage.Open(str(path))
    cache, meshes = UsdGeom.XformCache(), []
    for prim in stage.Traverse():
        if prim.GetName() != "visual":
            continue
        mesh, matrix = UsdGeom.Mesh(prim), np.array(cache.GetLocalToWorldTransform(prim))
        points = np.array(mesh.GetPointsAttr().Get()) @ matrix[:3, :3] + matrix[3, :3]
        faces = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
        st = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
        uv = np.array(st.ComputeFlattened()).reshape(-1, 3, 2) if st and st.HasValue() else None
        subsets = UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()
        groups = [(np.array(s.GetIndicesAttr().Get()), s.GetPrim()) for s in subsets] or [(np.arange(len(faces)), prim)]
        shown = UsdGeom.PrimvarsAPI(prim).GetPrimvar("displayColor")
        for which, owner in groups:
            material = UsdShade.MaterialBindingAPI(owner).ComputeBoundMaterial()[0]
            surface = material.ComputeSurfaceSource()[0]
            file, factor = None, [1, 1, 1]
            diffuse = surface.GetInput("diffuseColor")
            if diffuse.HasConnectedSource():
                source = UsdShade.Shader(diffuse.GetConnectedSources()[0][0].source.GetPrim())
                if source.GetInput("file"):
                    file = source.GetInput("file").Get().resolvedPath
                    scale = source.GetInput("scale").Get() if source.GetInput("scale") else None
                    factor = list(scale)[:3] if scale else factor
            elif diffuse.Get() is not None:
                factor = list(diffuse.Get())
            corners = points[faces[which]].reshape(-1, 3)
            part = trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)
            if file:
                image = np.asarray(Image.open(file).convert("RGB"))
                image = 255 * display(linear(image / 255) * factor)
                image = Image.fromarray(image.round().astype(np.uint8))
                visual = trimesh.visual.TextureVisuals(uv[which].reshape(-1, 2), image=image)
                visual.material.diffuse = [255] * 4
                part.visual = visual
            elif diffuse.HasConnectedSource() and shown.HasValue():
                rows = np.array(shown.ComputeFlattened()).reshape(-1, 3, 3)[which].mean(1)
                part.visual.face_colors = np.column_stack([255 * display(rows), np.full(len(rows), 255)]).round().astype(np.uint8)
            else:
                part.visual.face_colors = [*(255 * display(np.array(factor))).round().astype(np.uint8), 255]
            meshes.append(part)
    return meshes


def urdf(folder):
    """The URDF's visuals, each where its link stands at rest."""
    import xml.etree.ElementTree as tree

    root = tree.parse(folder / "asset.urdf").getroot()
    numbers = lambda node: np.array([float(x) for x in node.get("xyz", "0 0 0").split()]) if node is not None else np.zeros(3)
    above = {j.find("child").get("link"): (j.find("parent").get("link"), numbers(j.find("origin"))) for j in root.findall("joint")}

    def place(link):
        parent, shift = above.get(link, (None, np.zeros(3)))
        return shift if parent is None else shift + place(parent)

    meshes = []
    for link in root.iter("link"):
        for visual in link.iter("visual"):
            for mesh in looks.parts(folder / visual.find(".//mesh").get("filename")):
                mesh.apply_translation(place(link.get("name")) + numbers(visual.find("origin")))
                colour = visual.find("material/color")
                if colour is not None and mesh.visual.kind != "texture":
                    mesh.visual.face_colors = [round(255 * float(c)) for c in colour.get("rgba").split()]
                meshes.append(mesh)
    return meshes


def off(places, meshes, to_file):
    from scipy.spatial import cKDTree

    meshes = [m for m in meshes if len(m.faces)]
    areas = np.array([m.area for m in meshes])
    counts = (400_000 * areas / areas.sum()).astype(int) + 1
    shown = [looks.shown(m, n, 1) for m, n in zip(meshes, counts)]
    there, colours = to_file(np.vstack([p for p, _ in shown])), np.vstack([c for _, c in shown])
    low, size = there.min(0), np.ptp(there, 0).max()
    points, due_ = places
    low_due, size_due = points.min(0), np.ptp(points, 0).max()
    away, nearest = cKDTree((there - low) / size).query((points - low_due) / size_due)
    near = away < 0.01
    return (colours[nearest[near]] - due_[near]).mean(0), near.mean()


def main():
    kinfold, out, only = sys.argv[1], Path(sys.argv[2]), sys.argv[3:]
    rows, worst = [], 0.0
    for name, parts, writer in cases():
        if only and name not in only:
            continue
        folder = out / name.replace(" ", "_")
        folder.mkdir(parents=True, exist_ok=True)
        for stale in folder.glob("case.*"):
            stale.unlink()
        mesh = writer(parts, folder)
        (folder / "condition.json").write_text(json.dumps(CONDITION))
        words = [kinfold, "make", "--mesh", mesh, "--condition", folder / "condition.json", "--out", folder / "asset"]
        words += ["--export", "mjcf,usd,usdz,glb", "--state", out / "state", "--quiet"]
        made = subprocess.run([str(w) for w in words], capture_output=True, text=True)
        asset = folder / "asset"
        if not (asset / "asset.urdf").exists():
            print(f"{name}: NOTHING MADE: {made.stderr.strip()[-400:]}")
            continue
        places = [due(part) for part in parts]
        points, colours = np.vstack([p for p, _ in places]), np.vstack([c for _, c in places])
        # The asset stands with z up, or as glTF turns it, with what a file's nodes did to it.
        if name == "mirroring node":
            points = points * [-1, 1, 1]
        if name == "turned nodes":
            points = points @ np.array([[0, 0, -1], [0, 1, 0], [1, 0, 0]])
        y_up = lambda p: p
        z_up = lambda p: np.column_stack([p[:, 0], p[:, 2], -p[:, 1]])
        told = []
        for form, meshes, turn in [
            ("glb", looks.parts(asset / "asset.glb"), y_up),
            ("urdf", urdf(asset), z_up),
            ("usd", of_usd(asset / "asset.usda"), z_up),
        ]:
            colour, share = off((points, colours), meshes, turn)
            worst = max(worst, abs(colour).max())
            told.append(f"{form} {abs(colour).max():5.2f} ({share:.0%})")
        said = [line for line in made.stderr.splitlines() if "left out" in line or "colour" in line]
        print(f"{name:26} " + "  ".join(told) + ("  | " + "; ".join(said) if said else ""), flush=True)
        try:
            looks.of_mujoco(asset / "asset.xml", folder, "mujoco")
            rows.append(Image.open(folder / "mujoco.png").resize((960, 240)))
        except Exception as error:  # no display driver
            print(f"  no picture: {error}")
    print(f"largest mean error: {worst:.2f} of 255")
    if rows:
        sheet = Image.new("RGB", (960 * 2, 240 * ((len(rows) + 1) // 2)))
        for n, row in enumerate(rows):
            sheet.paste(row, (960 * (n % 2), 240 * (n // 2)))
        sheet.save(out / "sheet.png")


if __name__ == "__main__":
    main()
