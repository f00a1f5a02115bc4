"""The installed commands of this package; see `skin_models.started`."""

from skin_models.started import command

driver_node = command("skin_testbed_driver.ros.driver_node")
recorder = command("skin_testbed_driver.ros.recorder")
call = command("skin_testbed_driver.ros.call")
export_table = command("skin_testbed_driver.ros.export_table")
import_table = command("skin_testbed_driver.ros.import_table")
