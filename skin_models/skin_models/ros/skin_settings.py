"""The parameters of the skin node, and what they make: model, layout and kernel."""

import os
from dataclasses import dataclass
from pathlib import Path

from skin_models import layout as layouts
from skin_models.errors import SkinError
from skin_models.layout import A201_AREA, Layout
from skin_models.layout_file import load_layout
from skin_models.materials import material, names
from skin_models.model import Model
from skin_models.model_file import load_model
from skin_models.ros.parameters import setting
from skin_models.spread.kernels import Gaussian, GeneralisedGaussian, HeavyTail, Kernel
from skin_models.spread.noted import kernel_of, spread_width


@dataclass(frozen=True)
class SkinSettings:
    """Every parameter. Those that a running node cannot change are fixed."""

    model: str = setting("silicone_4mm", "a model file (YAML), or the name of a shipped material")
    drive: str = setting("contacts", "contacts: at `rate`; encoder: a plunger at the origin, once per sample of `encoder`",
                         choices=("contacts", "encoder"), fixed=True)  # fmt: skip
    layout: str = setting("model", "model: where the model says its taxels are, or a row of as many as it has shares",
                          choices=("model", "row", "grid", "hexagonal", "file"), fixed=True)  # fmt: skip
    layout_file: str = setting("", "table of taxels for layout:=file (name, x_mm, y_mm, z_mm, nx, ny, nz, area_mm2)", fixed=True)
    columns: int = setting(3, "taxels along x", lower=1, upper=1000, fixed=True)
    rows: int = setting(3, "taxels along y, for grid and hexagonal", lower=1, upper=1000, fixed=True)
    pitch: float = setting(0.014, "m, distance between neighbours", lower=1e-4, upper=1.0, fixed=True)
    taxel_area: float = setting(0.0, "m^2, sensing area; 0: the cell of a grid, a FlexiForce A201 in a row", lower=0.0, upper=1.0,
                                fixed=True)  # fmt: skip
    spread_width: float = setting(0.0, "m, width c of the spread; 0: the model's own, or 5.25 mm", lower=0.0, upper=1.0, fixed=True)
    spread_kernel: str = setting("gaussian", "shape of the spread", choices=("gaussian", "generalised_gaussian", "heavy_tail"), fixed=True)
    spread_power: float = setting(2.0, "power of a generalised Gaussian or a heavy tail", lower=0.5, upper=20.0, fixed=True)
    plunger_radius: float = setting(0.0, "m, of the patch of `wrench` and of `encoder`; 0 where the spread was measured with the plunger",
                                    lower=0.0, upper=1.0, fixed=True)  # fmt: skip
    rate: float = setting(100.0, "Hz, samples per second (drive:=contacts)", lower=1.0, upper=2000.0, fixed=True)
    contact_timeout: float = setting(0.2, "s without a message after which its contacts are stale", lower=0.001, upper=60.0)
    contact_decay: float = setting(0.05, "s, time constant with which stale contacts fall to zero", lower=0.001, upper=60.0)
    seed: int = setting(0, "seed of the model's random effects; -1 leaves those out", lower=-1, upper=2**31 - 1, fixed=True)
    skin_frame: str = setting("skin", "frame_id of taxels, taxel_layout and everything to look at", fixed=True)
    force_frame: str = setting("load_cell", "frame_id of force (drive:=encoder)", fixed=True)
    view_rate: float = setting(10.0, "Hz of markers, heat_map and points, while someone looks; 0: none", lower=0.0, upper=60.0, fixed=True)
    view_force: float = setting(5.0, "N that is drawn as full", lower=1e-3, upper=1e4)

    def __post_init__(self) -> None:
        """Refuse combinations that make no sense."""
        if self.layout == "file" and not self.layout_file:
            raise SkinError("layout:=file needs layout_file")
        if self.spread_kernel == "heavy_tail" and self.spread_power <= 1.0:
            raise SkinError(f"a heavy tail needs spread_power above 1, not {self.spread_power}")

    @property
    def random_seed(self) -> int | None:
        """The seed, or None."""
        return None if self.seed < 0 else self.seed

    def make_model(self) -> Model:
        """The model. Raises `SkinError` for a file or a name that cannot be used."""
        if not self.model:
            raise SkinError(f"parameter model names a YAML file or a material: {', '.join(names())}")
        if self.model in names() or not (Path(self.model).suffix or os.path.sep in self.model or Path(self.model).exists()):
            return material(self.model).model
        return load_model(self.model)

    def make_layout(self, model: Model) -> Layout:
        """Where the taxels are. Raises `SkinError` for a layout that cannot be used."""
        area = self.taxel_area or None
        if self.layout == "file":
            return load_layout(self.layout_file)
        if self.layout == "grid":
            return layouts.grid(self.columns, self.rows, self.pitch, area)
        if self.layout == "hexagonal":
            return layouts.hexagonal(self.columns, self.rows, self.pitch, area)
        if self.layout == "model" and not model.shares:
            raise SkinError("the model has no taxels (shares is empty): choose a layout")
        if self.layout == "model" and model.positions:
            return layouts.flat(model.positions, area or A201_AREA)
        return layouts.row(len(model.shares) if self.layout == "model" else self.columns, self.pitch, area or A201_AREA)

    def make_kernel(self, model: Model) -> Kernel:
        """The spread: as the model's notes say, unless a parameter here says otherwise."""
        width = self.spread_width or spread_width(model.notes)
        if self.spread_kernel == "gaussian":
            return Gaussian(width=width) if self.spread_width else kernel_of(model.notes)
        kernel = GeneralisedGaussian if self.spread_kernel == "generalised_gaussian" else HeavyTail
        return kernel(width=width, power=self.spread_power)
