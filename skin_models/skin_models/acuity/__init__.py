"""A designer's picture: how well a patch locates a contact, and how light a contact it detects. `skin_acuity OUT.png` draws it."""
