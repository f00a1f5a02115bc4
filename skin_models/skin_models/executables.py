"""The installed commands of this package; see `skin_models.started`."""

from skin_models.started import command

skin_node = command("skin_models.ros.skin_node")
mujoco_finger = command("skin_models.ros.mujoco_finger")
effects_gallery = command("skin_models.gallery.__main__")
skin_acuity = command("skin_models.acuity.__main__")
