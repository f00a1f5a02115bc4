"""All effects, found by looking into `skin_models.effects`: a new effect is one new file there and nothing else."""

import importlib
import inspect
import pkgutil
from functools import cache

import skin_models.effects
from skin_models.effect import Effect
from skin_models.errors import ModelError


@cache
def effects() -> tuple[type[Effect], ...]:
    """Every effect class, in the order of its file's name."""
    modules = (importlib.import_module(f"skin_models.effects.{m.name}") for m in pkgutil.iter_modules(skin_models.effects.__path__))
    return tuple(c for module in modules for c in vars(module).values() if _is_effect_of(c, module))


def _is_effect_of(c: object, module: object) -> bool:
    return inspect.isclass(c) and issubclass(c, Effect) and not inspect.isabstract(c) and c.__module__ == module.__name__


def effect_class(cause: str, where: str, form: str = "") -> type[Effect]:
    """The class that models `cause` at `where` (`taxel_3` finds `taxel`) in one of its forms.

    Raises `ModelError`, which lists the causes there are, or for a known cause its forms and places.
    """
    word = "taxel" if where.startswith("taxel") else where
    for c in effects():
        if (c.cause, c.form) == (cause, form) and word in c.places:
            return c
    asked = f"{cause!r}{form and f' of the form {form!r}'} in {where!r}"
    forms = sorted(f"{c.cause} {c.form and f'of the form {c.form} '}({', '.join(c.places)})" for c in effects() if c.cause == cause)
    known = "; ".join(forms) or ", ".join(sorted({c.cause for c in effects()}))
    raise ModelError(f"no effect models {asked}; known: {known}")
