"""What a case is: a scene file of one feature, and how it is compared."""

from dataclasses import dataclass
from pathlib import Path

FILM = 32
"""Side of a film [pixels]: four blocks."""

FLOOR = """
  <shape type="rectangle">
    <transform name="to_world"><scale value="4"/><translate z="-1"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.6, 0.5, 0.4"/></bsdf>
  </shape>"""
LAMP = """
  <shape type="rectangle">
    <transform name="to_world">
      <rotate x="1" angle="180"/><scale value="1.5"/><translate x="1" y="-1" z="3"/>
    </transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>
    <emitter type="area"><rgb name="radiance" value="6, 5, 4"/></emitter>
  </shape>"""
SKY = """
  <emitter type="constant"><rgb name="radiance" value="0.3, 0.4, 0.5"/></emitter>"""
VIEW = """
    <transform name="to_world">
      <lookat origin="1, -5, 2.5" target="0, 0, 0" up="0, 0, 1"/>
    </transform>"""
CAMERA = f"""
  <sensor type="perspective">
    <float name="fov" value="30"/>{VIEW}
    %FILM%
  </sensor>"""
BOX = """
  <shape type="cube" id="object">
    <transform name="to_world">
      <scale value="0.7"/><rotate z="1" angle="25"/><translate z="-0.2"/>
    </transform>
    %BSDF%
  </shape>"""
PANEL = """
  <shape type="rectangle" id="object">
    <transform name="to_world">
      <scale value="1.1"/><rotate x="1" angle="60"/><translate y="-0.5" z="0.2"/>
    </transform>
    %BSDF%
  </shape>"""
BALL = """
  <shape type="sphere" id="object"><float name="radius" value="1"/>
    %BSDF%
  </shape>"""


def film(side: int = FILM, rest: str = "", rfilter: str = '<rfilter type="box"/>') -> str:
    """Write a film."""
    return (
        f'<film type="hdrfilm"><integer name="width" value="{side}"/>'
        f'<integer name="height" value="{side}"/>'
        f'<string name="pixel_format" value="rgb"/>{rest}{rfilter}</film>'
    )


DEFAULTS = {"reflectance": "0.7, 0.4, 0.2", "alpha": "0.35", "radiance": "6, 5, 4"}
"""Values of parameters, which our side may be given others of, to see that this is told."""


@dataclass(frozen=True)
class Case:
    """A feature, its scene, and what is compared."""

    name: str
    """GROUP/FEATURE."""
    xml: str
    """The scene file but for its integrator, which `path` with `max_depth` completes."""
    max_depth: int = 6
    film: str = film()
    border: int = 0
    """So many pixels at the film's edge are left out."""
    particles: bool = False
    """Our light tracer against Mitsuba's is compared besides."""
    pdf: str = "same"
    """`same`: densities are those of Mitsuba; otherwise why our sampling law is another."""
    effort: int = 1
    """Multiple of the usual number of samples."""
    file: Path | None = None
    """A scene that is there already."""
    parameters: tuple[tuple[str, str], ...] = ()
    """Values of its parameters."""
    independent: Path | None = None
    """An image of it by a third renderer."""

    @property
    def table(self) -> float:
        """Relative error of a table that Mitsuba has instead of a formula.

        The transmittance of a rough coat has 64 entries with straight lines between. By their
        second differences these are off by up to 1.9e-4 at α = 0.3, for each of two directions; the
        rest is for the quadrature that makes the entries.
        """
        return 5e-4 if "roughplastic" in self.xml else 0.0

    @property
    def fit(self) -> float:
        """Relative error of Mitsuba's densities besides rounding.

        For Beckmann's microfacets, its default, the shadowing in densities of visible normals is a
        rational fit, off by up to 0.35 % (Walter et al. 2007); ours is exact, as samples of visible
        normals need it. Of a rough coat the share 1 − T of what is reflected, about 0.04 from
        above, has the error of the table of T, 1.9e-4. The clear coat of the principled model has
        1 + (α² − 1) cos² θ, which at α = 0.07 loses a factor 1 / α² = 200 of four roundings.
        """
        rational = 'type="rough' in self.xml and 'value="ggx"' not in self.xml
        coat = 1.9e-4 / 0.04 if "roughplastic" in self.xml else 0.0
        clear = 200 * 4 * 2.0**-24 if "clearcoat_gloss" in self.xml else 0.0
        return coat + clear + (0.0035 if rational else 0.0)

    @property
    def text(self) -> str:
        """The whole scene file."""
        body = self.xml.replace("%FILM%", self.film)
        integrator = (
            f'\n  <integrator type="path">'
            f'<integer name="max_depth" value="{self.max_depth}"/></integrator>'
        )
        defaults = "".join(
            f'\n  <default name="{name}" value="{value}"/>'
            for name, value in DEFAULTS.items()
            if f"${name}" in body
        )
        return f'<scene version="3.0.0">{defaults}{integrator}{body}\n</scene>\n'


def on(shape: str, bsdf: str) -> str:
    """Show a BSDF on a shape, on the floor, below lamp and sky."""
    return CAMERA + FLOOR + LAMP + SKY + shape.replace("%BSDF%", bsdf)
