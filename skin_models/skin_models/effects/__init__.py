"""One file per effect. `skin_models.catalogue` finds them."""
