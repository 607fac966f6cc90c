"""Zaber's own library with an axes' controller over TCP: what it reads, as one JSON object.

    zaber.py PORT

What fails stands there as the words of its error; whoever starts this judges.
"""

import json
import sys
import time

from zaber_motion import MotionLibException
from zaber_motion.ascii import Connection, DigitalOutputAction


def tried(action):
    try:
        return action()
    except MotionLibException as error:
        return f"{type(error).__name__}: {error}"


def flags(axis):
    return sorted(axis.warnings.get_flags())


def moved(move, axis):
    move()
    return axis.get_position()


def stopped(axis):
    axis.move_absolute(400000, wait_until_idle=False)
    time.sleep(0.05)
    axis.stop()
    return axis.get_position()


def said(line):
    line.default_request_timeout = 500
    (device,) = line.detect_devices(identify_devices=False)
    axis = device.get_axis(1)
    io = device.io
    steps = {
        "serial": lambda: device.generic_command("get system.serial").data,
        "flags_before": lambda: flags(axis),
        "homed_before": axis.is_homed,
        "home": lambda: moved(axis.home, axis),
        "homed": axis.is_homed,
        "flags": lambda: flags(axis),
        "absolute": lambda: moved(lambda: axis.move_absolute(128000), axis),
        "relative": lambda: moved(lambda: axis.move_relative(-4267), axis),
        "stopped": lambda: stopped(axis),
        "refused": lambda: axis.move_absolute(99999999, wait_until_idle=False),
        "outputs": lambda: (
            io.set_digital_output(1, DigitalOutputAction.ON),
            io.get_all_digital_outputs(),
        )[1],
        "volts": lambda: io.get_analog_input(1),
    }
    return {name: tried(step) for name, step in steps.items()}


try:
    with Connection.open_tcp("127.0.0.1", int(sys.argv[1])) as line:
        print(json.dumps(said(line)))
except MotionLibException as error:
    print(json.dumps({"error": f"{type(error).__name__}: {error}"}))
