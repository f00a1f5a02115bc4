"""The installed commands of this package; see `skin_models.started`."""

from skin_models.started import command

ident_node = command("skin_ident.ros.ident_node")
demo = command("skin_ident.ros.demo")
fit = command("skin_ident.cli.fit")
diagnose = command("skin_ident.cli.diagnose")
report = command("skin_ident.cli.report")
hide = command("skin_ident.cli.hide")
challenge = command("skin_ident.cli.challenge")
identify = command("skin_ident.cli.identify")
thesis = command("skin_ident.cli.thesis")
