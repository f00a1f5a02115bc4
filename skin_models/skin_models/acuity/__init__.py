"""A designer's picture: how well a patch locates a contact, and how light a contact it tells. `skin_acuity OUT.png` draws it."""
