"""The images and meshes that cases refer to, made anew for each run."""

import struct
import zlib
from pathlib import Path

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def write_assets(folder: Path) -> None:
    """Write all of them into a folder."""
    images(folder)
    positions, normals, uv, faces = knob()
    write_obj(folder / "knob.obj", positions, normals, uv, faces)
    vertices = np.hstack([positions, normals, uv])
    names = ["x", "y", "z", "nx", "ny", "nz", "u", "v"]
    for file, ascii_ in (("knob.ply", False), ("knob.ascii.ply", True)):
        write_ply(folder / file, names, vertices, faces, ascii_=ascii_)
    write_ply(folder / "bare.ply", names[:3], positions, faces)
    write_serialized(folder / "knobs.serialized", (positions[:, ::-1], normals, uv, faces), knob())
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    colours = np.array([[0.9, 0.1, 0.1], [0.1, 0.8, 0.2], [0.2, 0.1, 0.9], [0.7, 0.7, 0.1]])
    names = ["x", "y", "z", "u", "v", "r", "g", "b"]
    corners = np.hstack([square, square[:, :2] * 0.5 + 0.5, colours])
    write_ply(
        folder / "attributes.ply", names, corners, np.array([[0, 1, 2], [0, 2, 3]]), colours[:2]
    )


def images(folder: Path) -> None:
    """Write the textures: few texels, so that filters and wraps show."""
    random = np.random.RandomState(7)
    colours = random.uniform(0.1, 0.9, (6, 8, 3)).astype(np.float32)
    # Neither symmetric nor the same along both axes.
    colours[0, 0], colours[-1, 0] = (0.9, 0.05, 0.05), (0.05, 0.05, 0.9)
    bits = (colours * 255).round().astype(np.uint8)
    mi.Bitmap(bits).write(str(folder / "colours.png"))
    # Compression by blocks of pixels needs larger ones.
    mi.Bitmap(np.repeat(np.repeat(bits, 8, 0), 8, 1)).write(str(folder / "colours.jpg"))
    mi.Bitmap(colours).write(str(folder / "colours.exr"))
    mi.Bitmap(colours).write(str(folder / "colours.hdr"))
    greys = random.uniform(0.25, 0.75, (4, 5, 1))
    mi.Bitmap((greys * 255).round().astype(np.uint8)).write(str(folder / "greys.png"))
    v, u = np.mgrid[0:16, 0:16] / 16 * 2 * np.pi
    slopes = np.stack([0.3 * np.sin(u), 0.2 * np.cos(v + u), np.ones_like(u)], -1)
    slopes /= np.linalg.norm(slopes, axis=-1, keepdims=True)
    mi.Bitmap(((slopes * 0.5 + 0.5) * 255).round().astype(np.uint8)).write(
        str(folder / "normals.png")
    )
    waves = (0.5 + 0.3 * np.sin(u) * np.cos(v)).astype(np.float32)[..., None]
    mi.Bitmap(waves).write(str(folder / "grey.exr"))
    mi.Bitmap(np.repeat(waves, 3, axis=-1)).write(str(folder / "waves.exr"))
    y, x = np.mgrid[0:16, 0:32]
    sky = 0.3 + 4 * np.exp(-((x - 20) ** 2 + (y - 5) ** 2) / 8)
    sky = np.stack([sky, 0.2 + y / 20, 0.2 + x / 40], -1).astype(np.float32)
    mi.Bitmap(sky).write(str(folder / "sky.exr"))


def knob() -> tuple[Array, Array, Array, NDArray[np.int64]]:
    """Make a smooth closed body without symmetry, with normals that are not those of its faces."""
    rows, columns = 12, 18
    v, u = np.mgrid[0 : rows + 1, 0 : columns + 1] / np.array([rows, columns])[:, None, None]
    theta, phi = np.pi * v, 2 * np.pi * u
    direction = np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1
    )
    radius = 0.8 + 0.12 * direction[..., 0] * direction[..., 1] + 0.1 * direction[..., 2]
    positions = direction * radius[..., None]
    gradient = 0.12 * direction[..., [1, 0, 2]] * [1, 1, 0] + [0, 0, 0.1]
    tangential = gradient - direction * np.sum(gradient * direction, -1, keepdims=True)
    normals = direction * radius[..., None] - tangential
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    corner = np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    upper = np.stack([a, b, c], -1)[:-1].reshape(-1, 3)
    lower = np.stack([a, c, d], -1)[1:].reshape(-1, 3)
    uv = np.stack([u, v], -1)
    # Single precision, as in files: no reader need round.
    flat = [np.float64(np.float32(x.reshape(-1, x.shape[-1]))) for x in (positions, normals, uv)]
    return flat[0], flat[1], flat[2], np.vstack([upper, lower])


def write_obj(path: Path, positions: Array, normals: Array, uv: Array, faces: Array) -> None:
    """Write Wavefront's format."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in positions]
    lines += [f"vt {u:.9g} {v:.9g}" for u, v in uv]
    lines += [f"vn {x:.9g} {y:.9g} {z:.9g}" for x, y, z in normals]
    lines += ["f " + " ".join(f"{i}/{i}/{i}" for i in face + 1) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def write_ply(
    path: Path,
    names: list[str],
    vertices: Array,
    faces: Array,
    colours: Array | None = None,
    *,
    ascii_: bool = False,
) -> None:
    """Write Stanford's format; `colours` are those of faces."""
    of_faces = [] if colours is None else ["r", "g", "b"]
    header = [
        *("ply", f"format {'ascii' if ascii_ else 'binary_little_endian'} 1.0"),
        *(f"element vertex {len(vertices)}", *(f"property float {name}" for name in names)),
        *(f"element face {len(faces)}", "property list uchar int vertex_index"),
        *(f"property float {name}" for name in of_faces),
        "end_header",
    ]
    with path.open("wb") as file:
        file.write(("\n".join(header) + "\n").encode())
        if ascii_:
            for vertex in vertices:
                file.write((" ".join(f"{x:.9g}" for x in vertex) + "\n").encode())
            for face in faces:
                file.write(("3 " + " ".join(map(str, face)) + "\n").encode())
            return
        file.write(vertices.astype("<f4").tobytes())
        for index, face in enumerate(faces):
            file.write(struct.pack("<B3i", 3, *face))
            if colours is not None:
                file.write(colours[index].astype("<f4").tobytes())


def write_serialized(path: Path, *meshes: tuple[Array, Array, Array, Array]) -> None:
    """Write Mitsuba 0.5's format, version 4: deflated meshes, and where each begins."""
    data, offsets = b"", []
    for positions, normals, uv, faces in meshes:
        offsets.append(len(data))
        # Flags: normals, texture coordinates, single precision.
        body = struct.pack("<I", 0x0001 | 0x0002 | 0x1000) + b"mesh\0"
        body += struct.pack("<QQ", len(positions), len(faces))
        body += b"".join(array.astype("<f4").tobytes() for array in (positions, normals, uv))
        body += faces.astype("<u4").tobytes()
        data += struct.pack("<HH", 0x041C, 4) + zlib.compress(body)
    data += b"".join(struct.pack("<Q", offset) for offset in offsets)
    path.write_bytes(data + struct.pack("<I", len(meshes)))
