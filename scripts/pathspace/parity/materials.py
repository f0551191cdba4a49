"""Every BSDF, smooth and rough, plain and textured."""

from .case import BALL, BOX, PANEL, Case, on

COLOURS = '<texture type="bitmap" name="{}"><string name="filename" value="colours.png"/></texture>'
GREYS = (
    '<texture type="bitmap" name="{}"><string name="filename" value="greys.png"/>'
    '<boolean name="raw" value="true"/></texture>'
)
DIFFUSE = '<bsdf type="diffuse"><rgb name="reflectance" value="$reflectance"/></bsdf>'
METAL = '<bsdf type="roughconductor"><string name="material" value="Cu"/><float name="alpha" value="0.4"/></bsdf>'


def bsdf(kind: str, *inside: str) -> str:
    """Write a BSDF."""
    return f'<bsdf type="{kind}">{"".join(inside)}</bsdf>'


def number(name: str, value: float | str) -> str:
    """Write a number."""
    return f'<float name="{name}" value="{value}"/>'


def word(name: str, value: str) -> str:
    """Write a string."""
    return f'<string name="{name}" value="{value}"/>'


def rgb(name: str, value: str) -> str:
    """Write a colour."""
    return f'<rgb name="{name}" value="{value}"/>'


YES = '<boolean name="nonlinear" value="true"/>'
GOLD = rgb("eta", "0.143, 0.375, 1.442") + rgb("k", "3.983, 2.386, 1.603")


def microfacets(kind: str, *inside: str) -> list[tuple[str, str]]:
    """List a rough BSDF with each distribution, isotropic and not, constant and textured."""
    wide = number("alpha_u", 0.25) + number("alpha_v", 0.5)
    found = []
    for short, long in (("ggx", "ggx"), ("beckmann", "beckmann")):
        chosen = word("distribution", long)
        found += [
            (f"{kind}-{short}", bsdf(kind, chosen, number("alpha", "$alpha"), *inside)),
            (f"{kind}-{short}-anisotropic", bsdf(kind, chosen, wide, *inside)),
        ]
    chosen = word("distribution", "ggx")
    return [
        *found,
        (f"{kind}-textured-alpha", bsdf(kind, chosen, GREYS.format("alpha"), *inside)),
    ]


def principled() -> list[tuple[str, str]]:
    """List the principled model with its parameters."""
    base = rgb("base_color", "0.7, 0.4, 0.2")
    rough = number("roughness", 0.5)
    kinds = {
        "": "",
        "-metallic": number("metallic", 0.8),
        "-anisotropic": number("metallic", 0.5) + number("anisotropic", 0.8),
        "-specular": number("specular", 0.8) + number("spec_tint", 0.6),
        "-spec-trans": number("spec_trans", 0.7) + number("eta", 1.4),
        "-sheen": number("sheen", 0.9) + number("sheen_tint", 0.4),
        "-clearcoat": number("clearcoat", 0.9) + number("clearcoat_gloss", 0.3),
        "-flatness": number("flatness", 0.8),
    }
    found = [(f"principled{k}", bsdf("principled", base, rough, v)) for k, v in kinds.items()]
    textured = COLOURS.format("base_color") + GREYS.format("roughness") + GREYS.format("metallic")
    return [*found, ("principled-textured", bsdf("principled", textured))]


def opaque() -> list[tuple[str, str]]:
    """List what covers a box."""
    plastic = rgb("diffuse_reflectance", "0.7, 0.4, 0.2")
    textured = COLOURS.format("diffuse_reflectance")
    alpha = number("alpha", 0.3)
    beckmann, ggx = word("distribution", "beckmann"), word("distribution", "ggx")
    tinted = rgb("specular_reflectance", "0.9, 0.7, 0.5") + rgb(
        "specular_transmittance", "0.5, 0.8, 0.9"
    )
    return [
        ("diffuse", DIFFUSE),
        ("diffuse-textured", bsdf("diffuse", COLOURS.format("reflectance"))),
        ("conductor", bsdf("conductor", GOLD)),
        ("conductor-mirror", bsdf("conductor", word("material", "none"))),
        (
            "conductor-textured",
            bsdf("conductor", word("material", "Al"), COLOURS.format("specular_reflectance")),
        ),
        *[
            (f"conductor-{m}", bsdf("conductor", word("material", m)))
            for m in ("Au", "Ag", "Cu", "Al", "W")
        ],
        *microfacets("roughconductor", GOLD),
        (
            "roughconductor-textured",
            bsdf("roughconductor", GOLD, alpha, COLOURS.format("specular_reflectance")),
        ),
        ("dielectric", bsdf("dielectric", number("int_ior", 1.5), number("ext_ior", 1.0))),
        (
            "dielectric-named",
            bsdf("dielectric", word("int_ior", "diamond"), word("ext_ior", "water")),
        ),
        ("dielectric-tinted", bsdf("dielectric", tinted)),
        ("dielectric-textured", bsdf("dielectric", COLOURS.format("specular_transmittance"))),
        *microfacets("roughdielectric", number("int_ior", 1.5), number("ext_ior", 1.0)),
        ("roughdielectric-tinted", bsdf("roughdielectric", alpha, tinted)),
        (
            "roughdielectric-textured",
            bsdf("roughdielectric", alpha, COLOURS.format("specular_transmittance")),
        ),
        ("plastic", bsdf("plastic", plastic)),
        ("plastic-nonlinear", bsdf("plastic", plastic, YES)),
        ("plastic-textured", bsdf("plastic", textured, YES)),
        ("roughplastic-ggx", bsdf("roughplastic", plastic, ggx, alpha)),
        ("roughplastic-beckmann", bsdf("roughplastic", plastic, beckmann, alpha)),
        ("roughplastic-nonlinear", bsdf("roughplastic", plastic, ggx, alpha, YES)),
        ("roughplastic-textured", bsdf("roughplastic", textured, ggx, alpha)),
        *principled(),
        ("twosided", bsdf("twosided", DIFFUSE)),
        ("blendbsdf", bsdf("blendbsdf", number("weight", 0.3), DIFFUSE, METAL)),
        ("blendbsdf-textured", bsdf("blendbsdf", GREYS.format("weight"), DIFFUSE, METAL)),
    ]


def panels() -> list[tuple[str, str]]:
    """List what is seen through, or from behind."""
    back = bsdf("roughplastic", number("alpha", 0.3))
    return [
        ("thindielectric", bsdf("thindielectric", number("int_ior", 1.5))),
        (
            "thindielectric-textured",
            bsdf("thindielectric", COLOURS.format("specular_transmittance")),
        ),
        ("null", bsdf("null")),
        ("mask", bsdf("mask", number("opacity", 0.6), DIFFUSE)),
        ("mask-rough", bsdf("mask", number("opacity", 0.6), METAL)),
        ("mask-textured", bsdf("mask", GREYS.format("opacity"), DIFFUSE)),
        ("twosided-two", bsdf("twosided", back, DIFFUSE)),
    ]


def normals() -> list[tuple[str, str]]:
    """List what turns normals."""
    map_ = '<texture type="bitmap" name="normalmap"><string name="filename" value="normals.png"/><boolean name="raw" value="true"/></texture>'
    bump = '<texture type="bitmap" name="arbitrary"><string name="filename" value="waves.exr"/><boolean name="raw" value="true"/></texture>'
    return [
        ("bumpmap", bsdf("bumpmap", bump, number("scale", 0.15), DIFFUSE)),
        ("bumpmap-rough", bsdf("bumpmap", bump, number("scale", 0.15), METAL)),
        ("normalmap", bsdf("normalmap", map_, DIFFUSE)),
        ("normalmap-rough", bsdf("normalmap", map_, METAL)),
    ]


OWN_LAWS = {
    "plastic-textured": "by the colour of the point, in Mitsuba by the mean of the texture",
    "roughplastic-textured": "by the colour of the point, in Mitsuba by the mean of the texture",
    "bumpmap": "a mixture of both turns of the normal",
    "bumpmap-rough": "a mixture of both turns of the normal",
    "normalmap": "a mixture of both turns of the normal",
    "normalmap-rough": "a mixture of both turns of the normal",
}
"""Where we draw directions in another way than Mitsuba, and why."""


def cases() -> list[Case]:
    """List the cases of this module."""

    def case(name: str, shape: str, text: str) -> Case:
        return Case(f"bsdf/{name}", on(shape, text), pdf=OWN_LAWS.get(name, "same"))

    ball = [("roughconductor", METAL), ("dielectric", bsdf("dielectric")), ("diffuse", DIFFUSE)]
    return [
        *[case(name, BOX, text) for name, text in opaque()],
        *[case(name, PANEL, text) for name, text in panels() + normals()],
        *[case(f"{name}-ball", BALL, text) for name, text in ball],
    ]
