"""A page with a picture of every effect: the same press with it and without it. `effects_gallery OUT.html` writes it."""

TITLE = "<title>Effects</title>"  # of the page, by which it is known again
