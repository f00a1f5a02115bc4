"""The installed commands of this package; see `skin_models.started`."""

from skin_models.started import command

profile_server = command("skin_motion_profiles.ros.profile_server")
execute = command("skin_motion_profiles.ros.execute")
plot = command("skin_motion_profiles.cli.plot")
