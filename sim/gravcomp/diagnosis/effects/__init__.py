"""The vocabulary: every effect that a diagnosis can name. One file per effect; a file here is all that it takes."""

import importlib
import pkgutil

from gravcomp.diagnosis.effects.base import Effect


def _in_this_folder() -> tuple[type[Effect], ...]:
    modules = [importlib.import_module(f"{__name__}.{found.name}") for found in pkgutil.iter_modules(__path__)]
    return tuple(
        kind
        for module in modules
        for kind in vars(module).values()
        if isinstance(kind, type) and issubclass(kind, Effect) and kind.__module__ == module.__name__ and kind.name
    )


EFFECTS = _in_this_folder()
NAMES = tuple(dict.fromkeys(effect.name for effect in EFFECTS))


def effect_named(name: str) -> Effect:
    """An effect by its name; KeyError when it is not in the vocabulary."""
    return {effect.name: effect for effect in reversed(EFFECTS)}[name]()
