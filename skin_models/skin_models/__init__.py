"""The physics of robot skin: constitutive elements, the dispersion model, its spread over taxels, sensor chains, one file per effect."""
