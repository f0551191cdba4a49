"""Loads scenes of a million triangles with pathspace and with Mitsuba, in turn: time and memory.

`python tests/benches/load.py` in the repository's folder, after `scripts/setup`. The scenes are a
bumpy sphere as binary PLY and as OBJ, with normals and texture coordinates, and triangles strewn
at random. Each load is a process of its own; of several the fastest counts. A load of Mitsuba ends
when it has built its tree and, in the vectorised variant, when the scene can be rendered.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

Mesh = tuple[np.ndarray, np.ndarray | None, np.ndarray | None, np.ndarray]

SCENE = """<scene version="3.0.0"><emitter type="constant"/><sensor type="perspective">
  <transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
  <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/></film>
  </sensor><integrator type="path"/>
  <shape type="{kind}"><string name="filename" value="{name}"/><bsdf type="twosided">
    <bsdf type="diffuse"/></bsdf></shape></scene>"""

MITSUBA = """
import json, resource, sys, time
import mitsuba
mitsuba.set_variant(sys.argv[1])
start, cpu = time.perf_counter(), time.process_time()
scene = mitsuba.load_file(sys.argv[2])
import drjit
drjit.sync_thread()
seconds, cpu = time.perf_counter() - start, time.process_time() - cpu
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
print(json.dumps({"read_s": seconds, "cpu_s": cpu, "peak_mib": peak}))
"""


def sphere(side: int) -> Mesh:
    """2 side² triangles."""
    theta = np.linspace(0, np.pi, side + 1)[:, None]
    phi = np.linspace(0, 2 * np.pi, side + 1)[None, :]
    radius = 1 + 0.05 * np.sin(40 * theta) * np.sin(40 * phi) + 0.01 * np.sin(311 * theta + 7 * phi)
    directions = (np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi)
    normals = np.stack(directions, -1)
    positions = normals * radius[..., None]
    texcoords = np.stack(np.broadcast_arrays(phi / (2 * np.pi), theta / np.pi), -1)
    corner = np.arange(side)[:, None] * (side + 1) + np.arange(side)[None, :]
    below, other = corner + side + 1, corner + side + 2
    triangles = [(corner, below, other), (corner, other, corner + 1)]
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in triangles])
    return positions.reshape(-1, 3), normals.reshape(-1, 3), texcoords.reshape(-1, 2), faces


def soup(count: int) -> Mesh:
    """Small triangles in a cube."""
    random = np.random.default_rng(1)
    centres = random.uniform(-1, 1, (count, 1, 3))
    corners = centres + random.normal(0, 0.01, (count, 3, 3))
    return corners.reshape(-1, 3), None, None, np.arange(3 * count).reshape(-1, 3)


def write_ply(path: Path, mesh: Mesh) -> None:
    """Binary, little endian."""
    positions, normals, texcoords, faces = mesh
    columns = [array for array in (positions, normals, texcoords) if array is not None]
    names = ["x", "y", "z"] + (["nx", "ny", "nz", "u", "v"] if normals is not None else [])
    properties = "".join(f"property float {name}\n" for name in names)
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(positions)}\n{properties}"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    records = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    records["count"] = 3
    records["corners"] = faces
    vertices = np.concatenate(columns, axis=1).astype("<f4")
    path.write_bytes(header.encode() + vertices.tobytes() + records.tobytes())


def write_obj(path: Path, mesh: Mesh) -> None:
    """With indices of texture coordinates and normals."""
    positions, normals, texcoords, faces = mesh
    with path.open("w") as file:
        np.savetxt(file, positions, "v %.6g %.6g %.6g")
        np.savetxt(file, texcoords, "vt %.6g %.6g")
        np.savetxt(file, normals, "vn %.4f %.4f %.4f")
        corners = np.repeat(faces + 1, 3, axis=1)
        np.savetxt(file, corners, "f " + " ".join(["%d/%d/%d"] * 3))


def best(command: list[str], runs: int) -> dict[str, float]:
    """What the fastest of several runs printed."""
    results = []
    for _ in range(runs):
        output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        results.append(json.loads(output.splitlines()[-1]))
    return min(results, key=lambda result: result["read_s"] + result.get("build_s", 0))


def build() -> Path:
    """The benchmark's binary."""
    command = ["cargo", "bench", "--bench", "load", "--no-run"]
    messages = subprocess.run(command, check=True, capture_output=True, text=True).stderr
    found = re.search(r"Executable .*\((.*)\)", messages)
    if found is None:
        raise SystemExit(f"cargo names no executable:\n{messages}")
    return Path(found[1])


def main() -> None:
    """Prints a table in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--program", type=Path, help="the benchmark's binary, else it is built")
    parser.add_argument("--variants", default="scalar_rgb,llvm_ad_rgb")
    options = parser.parse_args()
    program = options.program or build()
    scenes = [
        ("sphere.ply", sphere(708), write_ply),
        ("sphere.obj", sphere(708), write_obj),
        ("soup.ply", soup(1_000_000), write_ply),
    ]
    row("scene", "program", "read", "build", "sum [s]", "CPU time [s]", "peak [MiB]", "ns a ray")
    row(*["---"] * 8)
    with tempfile.TemporaryDirectory() as folder:
        for name, mesh, write in scenes:
            write(Path(folder, name), mesh)
            scene = Path(folder, name + ".xml")
            scene.write_text(SCENE.format(kind=name.rsplit(".", 1)[1], name=name))
            ours = best([str(program), str(scene)], options.runs)
            read, built = ours["read_s"], ours["build_s"]
            rays = f"{ours['closest_ns']:.0f}, {ours['occluded_ns']:.0f}"
            row(name, "pathspace", read, built, read + built, ours["cpu_s"], ours["peak_mib"], rays)
            for variant in options.variants.split(","):
                command = [sys.executable, "-c", MITSUBA, variant, str(scene)]
                theirs = best(command, options.runs)
                seconds, cpu, peak = (theirs[key] for key in ["read_s", "cpu_s", "peak_mib"])
                row(name, f"Mitsuba {variant}", "", "", seconds, cpu, peak, "")


def row(*cells: str | float) -> None:
    """Prints a row of the table."""
    texts = (f"{cell:.4g}" if isinstance(cell, float) else cell for cell in cells)
    print("| " + " | ".join(texts) + " |", flush=True)


if __name__ == "__main__":
    main()
