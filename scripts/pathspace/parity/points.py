"""Values of Mitsuba point by point, in `scalar_rgb`: what its Python API answers to queries.

`points.json` of a case holds lists, of which a group has its own:

surfaces
    Of `bsdf`, `texture`, `shape`: hits of camera rays. `origin` and `direction` of the ray,
    `position` of the hit, and `pairs`: `from` (towards the sensor), `to` (towards the emitter),
    `value`, the scattering function times the shading cosine of `to`, and `pdf` of drawing `to` per
    solid angle; `dirac`: the same for lobes of no width, `value` the weight times the probability
    `pdf`; `albedos`: `from`, `mean` and `error` (standard) of the weights of samples.
seen
    Of `emitter`: `origin` and `direction` of a ray, and the `radiance` that comes along it.
lights
    Of `emitter`: `position` of a point, `direction` towards the light, its `value` per solid angle,
    or as irradiance on a surface that faces it where it is `dirac`, and the `pdf` of drawing it.
rays
    Of `sensor`: `film` and `aperture` samples, the `origin` and `direction` of the ray for them.

Directions are in the world and exactly what single precision holds.
"""

from pathlib import Path
from typing import Any

import numpy as np

from pathspace.files import write_json

from .case import Case

GRID = 7
"""Camera rays per side of the film."""
HITS = 5
FROM, TO = 6, 24
"""Directions at a hit: towards the sensor, and for each of them towards the emitter."""
SAMPLES = 1000
"""Samples of an albedo."""


def write_points(path: Path, case: Case, scene: Any) -> None:  # noqa: ANN401
    """Ask for all values of a case, of a scene that `scalar_rgb` has loaded."""
    group = case.name.split("/", 1)[0]
    answers: dict[str, Any] = {}
    if group in ("bsdf", "texture", "shape"):
        answers["surfaces"] = surfaces(scene)
    elif group == "emitter":
        answers["seen"] = seen(scene)
        answers["lights"] = lights(scene)
    elif group == "sensor":
        answers["rays"] = rays(scene)
    else:
        return
    write_json(path, answers)


def numbers(vector: Any) -> list[float]:  # noqa: ANN401
    """Give the components of a vector."""
    return [float(x) for x in np.array(vector, dtype=np.float32).reshape(-1)]


def sphere(count: int, turn: float) -> list[list[float]]:
    """Spread directions evenly (Fibonacci), rounded to single precision."""
    index = np.arange(count) + 0.5
    z = 1 - 2 * index / count
    phi = index * np.pi * (3 - np.sqrt(5)) + turn
    sine = np.sqrt(1 - z * z)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), z], -1).astype(np.float32).tolist()


def camera_rays(scene: Any) -> list[Any]:  # noqa: ANN401
    """Draw a grid of rays over the film."""
    import mitsuba as mi

    sensor = scene.sensors()[0]
    places = [((i + 0.37) / GRID, (j + 0.61) / GRID) for j in range(GRID) for i in range(GRID)]
    found = [sensor.sample_ray(0.0, 0.5, mi.Point2f(*at), mi.Point2f(0.4, 0.7))[0] for at in places]
    return [mi.Ray3f(mi.Point3f(numbers(r.o)), mi.Vector3f(numbers(r.d))) for r in found]


def surfaces(scene: Any) -> list[dict[str, Any]]:  # noqa: ANN401
    """Scatter where rays hit the object, or any surface where none is called so."""
    import mitsuba as mi

    hits = [(ray, si) for ray in camera_rays(scene) if (si := scene.ray_intersect(ray)).is_valid()]
    hits = [(ray, si) for ray, si in hits if not si.shape.is_emitter()]
    objects = [(ray, si) for ray, si in hits if si.shape.id() == "object"]
    hits = objects or hits
    hits = [hits[len(hits) * i // HITS] for i in range(min(HITS, len(hits)))]
    context, found = mi.BSDFContext(), []
    for number, (ray, si) in enumerate(hits):
        bsdf, pairs, dirac, albedos = si.bsdf(ray), [], [], []
        for turn, towards in enumerate(sphere(FROM, 0.3 + number)):
            si.wi = si.to_local(mi.Vector3f(towards))
            for to in sphere(TO, 0.1 * turn + number):
                value, pdf = bsdf.eval_pdf(context, si, si.to_local(mi.Vector3f(to)))
                pairs.append(
                    {"from": towards, "to": to, "value": numbers(value), "pdf": float(pdf)}
                )
            dirac += [{"from": towards, **lobe} for lobe in lobes(bsdf, context, si)]
            if turn % 2 == 0:
                albedos.append({"from": towards, **albedo(bsdf, context, si)})
        place = {"origin": ray.o, "direction": ray.d, "position": si.p}
        place = {name: numbers(vector) for name, vector in place.items()}
        found.append({**place, "pairs": pairs, "dirac": dirac, "albedos": albedos})
    return found


def lobes(bsdf: Any, context: Any, si: Any) -> list[dict[str, Any]]:  # noqa: ANN401
    """List the lobes without width, each once."""
    import mitsuba as mi

    found: dict[tuple[float, ...], dict[str, Any]] = {}
    for choice in np.linspace(0.02, 0.98, 13):
        sample, weight = bsdf.sample(context, si, float(choice), mi.Point2f(0.3, 0.6))
        if sample.pdf > 0 and mi.has_flag(sample.sampled_type, mi.BSDFFlags.Delta):
            to = numbers(si.to_world(sample.wo))
            value = [float(sample.pdf) * x for x in numbers(weight)]
            entry = {"to": to, "value": value, "pdf": float(sample.pdf)}
            found[tuple(round(x, 4) for x in to)] = entry
    return list(found.values())


def albedo(bsdf: Any, context: Any, si: Any) -> dict[str, Any]:  # noqa: ANN401
    """Estimate what is scattered of all that goes out."""
    import mitsuba as mi

    random = np.random.RandomState(11).uniform(size=(SAMPLES, 3)).astype(np.float32).tolist()
    weights = np.array(
        [numbers(bsdf.sample(context, si, u, mi.Point2f(v, w))[1]) for u, v, w in random]
    )
    error = weights.std(axis=0, ddof=1) / np.sqrt(SAMPLES)
    return {"mean": weights.mean(axis=0).tolist(), "error": error.tolist()}


def seen(scene: Any) -> list[dict[str, Any]]:  # noqa: ANN401
    """Look for emission, from above the floor in all directions, and by the camera."""
    import mitsuba as mi

    origin = mi.Point3f(0.0, -1.0, 0.8)
    views = [mi.Ray3f(origin, mi.Vector3f(d)) for d in sphere(400, 0.2)] + camera_rays(scene)
    found = []
    for ray in views:
        si = scene.ray_intersect(ray)
        emitter = si.emitter(scene)
        if emitter is not None:
            value = numbers(emitter.eval(si))
            found.append({"origin": numbers(ray.o), "direction": numbers(ray.d), "radiance": value})
    return found


def lights(scene: Any) -> list[dict[str, Any]]:  # noqa: ANN401
    """Draw each light's direction from points on surfaces."""
    import drjit as dr
    import mitsuba as mi

    hits = [si for ray in camera_rays(scene) if (si := scene.ray_intersect(ray)).is_valid()]
    hits = [si for si in hits if not si.shape.is_emitter()][:: max(1, len(hits) // 12)]
    found = []
    for number, si in enumerate(hits):
        for emitter in scene.emitters():
            for u, v in ((0.2, 0.7), (0.6, 0.35), (0.85, 0.9)):
                sample = mi.Point2f((u + 0.13 * number) % 1, v)
                record, weight = emitter.sample_direction(si, sample)
                if record.pdf == 0 or dr.all(weight == 0):
                    continue
                dirac = mi.has_flag(emitter.flags(), mi.EmitterFlags.DeltaPosition) or mi.has_flag(
                    emitter.flags(), mi.EmitterFlags.DeltaDirection
                )
                if not dirac and scene.ray_test(si.spawn_ray_to(record.p)):
                    continue
                value = [float(record.pdf) * x for x in numbers(weight)]
                found.append(
                    {
                        "position": numbers(si.p),
                        "direction": numbers(record.d),
                        "value": value,
                        "pdf": float(record.pdf),
                        "dirac": bool(dirac),
                    }
                )
                if dirac:
                    break
    return found


def rays(scene: Any) -> list[dict[str, Any]]:  # noqa: ANN401
    """Draw rays for samples of film and aperture."""
    import mitsuba as mi

    sensor = scene.sensors()[0]
    found = []
    for i in range(60):
        film = [(0.5 + i * 0.7548776662) % 1, (0.5 + i * 0.5698402910) % 1]
        aperture = [(0.5 + i * 0.61803398875) % 1, (0.5 + i * 0.4142135) % 1]
        film, aperture = (np.array(x, np.float32).tolist() for x in (film, aperture))
        try:
            ray, _ = sensor.sample_ray(0.0, 0.5, mi.Point2f(film), mi.Point2f(aperture))
        except RuntimeError:
            return []  # Meters on shapes have ray differentials only.
        entry = {"film": film, "aperture": aperture}
        found.append({**entry, "origin": numbers(ray.o), "direction": numbers(ray.d)})
    return found
