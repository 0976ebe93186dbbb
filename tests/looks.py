"""Looks at one asset in every format beside the mesh it was made of. Outside of CI: it needs a display
driver (`MUJOCO_GL=egl`) and `pip install mujoco usd-core trimesh scipy pillow numpy`.

    python tests/looks.py MESH.glb ASSET_FOLDER [PICTURES_FOLDER]

Prints a line for each format: how large it is beside the mesh, and the mean colour of what it shows,
weighed by area, beside that of the mesh. With a folder for pictures, MuJoCo's are written there.
"""

import os
import sys
from pathlib import Path

os.environ.setdefault("MUJOCO_GL", "egl")

import numpy as np
import trimesh
from PIL import Image


def shown(mesh, count=20_000, seed=0):
    """Points spread over a surface, and their colours, sRGB, 0 to 255."""
    points, faces = trimesh.sample.sample_surface(mesh, count, seed=seed)[:2]
    return points, colours_at(mesh, points, faces)


def colours_at(mesh, points, faces):
    visual = mesh.visual
    if visual.kind == "texture" and getattr(visual, "uv", None) is not None:
        corners = mesh.triangles[faces]
        weights = trimesh.triangles.points_to_barycentric(corners, points)
        uv = (visual.uv[mesh.faces[faces]] * weights[:, :, None]).sum(axis=1)
        material = visual.material
        if hasattr(material, "baseColorTexture"):
            image, factor = material.baseColorTexture, material.baseColorFactor
        else:
            image, factor = material.image, material.diffuse
        factor = np.array([255, 255, 255] if factor is None else factor[:3], float)
        if image is None:
            return np.tile(factor, (len(points), 1))
        pixels = np.asarray(image.convert("RGB"), float)
        height, width = pixels.shape[:2]
        x = np.floor(uv[:, 0] % 1 * width).astype(int).clip(0, width - 1)
        y = np.floor((1 - uv[:, 1]) % 1 * height).astype(int).clip(0, height - 1)
        return pixels[y, x] * factor / 255
    if visual.kind == "texture":
        colour = getattr(visual.material, "baseColorFactor", None)
        colour = getattr(visual.material, "diffuse", colour) if colour is None else colour
        colour = [255, 255, 255] if colour is None else colour
        return np.tile(np.array(colour[:3], float), (len(points), 1))
    return np.asarray(visual.face_colors[faces][:, :3], float)


def mean(meshes):
    """Mean colour of several surfaces, by their area."""
    meshes = [m for m in meshes if len(m.faces)]
    areas = np.array([m.area for m in meshes])
    return (np.array([shown(m)[1].mean(axis=0) for m in meshes]) * areas[:, None]).sum(0) / areas.sum()


def spread(meshes, count, seed):
    """Points over several surfaces by their area, in a box from 0 to 1, and their colours."""
    meshes = [m for m in meshes if len(m.faces)]
    areas = np.array([m.area for m in meshes])
    counts = (count * areas / areas.sum()).astype(int) + 1
    all_ = [shown(m, n, seed) for m, n in zip(meshes, counts)]
    points, colours = np.vstack([p for p, _ in all_]), np.vstack([c for _, c in all_])
    low, high = np.min([m.bounds[0] for m in meshes], 0), np.max([m.bounds[1] for m in meshes], 0)
    return (points - low) / (high - low).max(), colours


def beside(due, meshes):
    """Mean of what the asset shows less what the mesh shows in the same places, each channel: caps and
    backs count for nothing, for the mesh has nothing there."""
    from scipy.spatial import cKDTree

    points, colours = due
    there, shows = spread(meshes, 400_000, 1)
    off, nearest = cKDTree(there).query(points)
    near = off < 0.01
    return (shows[nearest[near]] - colours[near]).mean(axis=0), near.mean()


def parts(path):
    scene = trimesh.load_scene(path) if hasattr(trimesh, "load_scene") else trimesh.load(path)
    return scene.dump() if isinstance(scene, trimesh.Scene) else [scene]


def of_urdf(folder):
    import xml.etree.ElementTree as tree

    files = [m.get("filename") for m in tree.parse(folder / "asset.urdf").iterfind(".//visual//mesh")]
    return [mesh for file in files for mesh in parts(folder / file)]


def of_mujoco(path, pictures, name):
    """Pictures from four sides; returns the last one's mean colour where anything is seen."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    model.vis.headlight.ambient[:] = 1
    model.vis.headlight.diffuse[:] = 0
    model.vis.headlight.specular[:] = 0
    model.mat_emission[:] = 0
    renderer = mujoco.Renderer(model, 480, 480)
    camera, option = mujoco.MjvCamera(), mujoco.MjvOption()
    option.geomgroup[:] = [1, 1, 1, 0, 0, 0]
    if path.suffix == ".urdf":
        # Without groups in a URDF, what has no contact is what is seen.
        model.geom_rgba[(model.geom_contype > 0), 3] = 0
    camera.lookat[:] = model.stat.center
    camera.distance = 2.2 * model.stat.extent
    camera.elevation = -20
    tiles = []
    for azimuth in (90, 180, 270, 0):
        camera.azimuth = azimuth
        renderer.update_scene(data, camera, option)
        tiles.append(renderer.render().copy())
    if pictures:
        Image.fromarray(np.hstack(tiles)).save(pictures / f"{name}.png")
    pixels = np.vstack(tiles).reshape(-1, 3).astype(float)
    return pixels[pixels.sum(axis=1) > 0].mean(axis=0)


def of_usd(path):
    """What a USD reader makes of the layer: its materials, their files, and faces without any."""
    from pxr import Usd, UsdGeom, UsdShade

    stage = Usd.Stage.Open(str(path))
    textures, unbound = set(), 0
    for prim in stage.Traverse():
        if prim.GetName() == "visual":
            subsets = UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()
            count = len(UsdGeom.Mesh(prim).GetFaceVertexCountsAttr().Get())
            bound = sum(len(s.GetIndicesAttr().Get()) for s in subsets)
            unbound += count - bound if subsets else 0
        if prim.GetTypeName() == "Shader":
            file = UsdShade.Shader(prim).GetInput("file")
            if file:
                textures.add(file.Get().resolvedPath)
    missing = [t for t in textures if not t or not Path(t).is_file()]
    return len(textures), len(missing), unbound


def main():
    mesh, folder = Path(sys.argv[1]), Path(sys.argv[2])
    pictures = Path(sys.argv[3]) if len(sys.argv) > 3 else None
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    size = mesh.stat().st_size
    due = mean(parts(mesh))
    places = spread(parts(mesh), 40_000, 0)
    print(f"mesh: {size} bytes, colour {due.round(1)}")

    def told(name, colour, files):
        bytes_ = sum(f.stat().st_size for f in files)
        off = abs(colour - due).max()
        print(f"{name}: {bytes_ / size:.2f} of the mesh, colour {colour.round(1)}, off by {off:.1f} of 255")

    off, share = beside(places, parts(folder / "asset.glb"))
    print(f"glb where the mesh is: off by {abs(off).max():.2f} of 255 ({share:.0%} of the mesh found)")
    meshes = folder / "meshes"
    seen = [f for f in meshes.iterdir() if f.suffix in (".png", ".mtl")]
    seen += [f for f in meshes.glob("*.obj") if "usemtl" in f.read_text()]
    told("urdf (trimesh)", mean(of_urdf(folder)), seen)
    told("glb (trimesh)", mean(parts(folder / "asset.glb")), [folder / "asset.glb"])
    pngs = [f for f in seen if f.suffix == ".png"]
    textures, missing, unbound = of_usd(folder / "asset.usda")
    bytes_ = (folder / "asset.usda").stat().st_size + sum(f.stat().st_size for f in pngs)
    print(f"usd: {bytes_ / size:.2f} of the mesh, {textures} textures, {missing} missing, {unbound} faces unbound")
    for name in ("asset.xml", "asset.urdf"):
        colour = of_mujoco(folder / name, pictures, name.replace(".", "_"))
        print(f"{name} (MuJoCo): colour {colour.round(1)} of what is seen from four sides")


if __name__ == "__main__":
    main()
