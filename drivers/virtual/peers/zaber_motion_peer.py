"""Zaber's own library against the axes' twin over TCP.

    pip install zaber-motion==10.2.0
    python drivers/virtual/peers/zaber_motion_peer.py target/debug/isolux
"""

import json
import subprocess
import sys
import time

from zaber_motion import MotionLibException
from zaber_motion.ascii import Connection, DigitalOutputAction

twin = subprocess.Popen(
    [sys.argv[1], "virtual", "axis", "--tcp", "0", "--lasts-s", "60", "--json"], stdout=subprocess.PIPE, text=True
)
try:
    host, port = json.loads(twin.stdout.readline())["address"].removeprefix("tcp://").split(":")
    with Connection.open_tcp(host, int(port)) as line:
        (device,) = line.detect_devices(identify_devices=False)
        axis = device.get_axis(1)
        assert not axis.is_homed() and axis.warnings.get_flags() == {"WR", "WH"}
        axis.home()
        assert axis.is_homed() and not axis.warnings.get_flags()
        axis.move_absolute(128000)
        assert axis.get_position() == 128000
        axis.move_relative(-4267)
        assert axis.get_position() == 123733
        axis.move_absolute(400000, wait_until_idle=False)
        time.sleep(0.3)
        axis.stop()
        assert 123733 < axis.get_position() < 400000
        try:
            axis.move_absolute(99999999)
            raise AssertionError("a target outside the limits was taken")
        except MotionLibException as refused:
            assert "BADDATA" in str(refused)
        device.io.set_digital_output(1, DigitalOutputAction.ON)
        assert device.io.get_all_digital_outputs() == [True, False, False, False]
        assert 4.8 < device.io.get_analog_input(1) < 5.1
finally:
    twin.terminate()
    twin.wait()
print("zaber-motion and the twin understand each other")
