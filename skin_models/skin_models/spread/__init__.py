"""How a force on the skin's surface reaches the taxels below: kernels, contact patches, the field over a layout, and its dynamics."""
