"""pyvisa-py as a client of an SCPI instrument, for tests/interoperability.

    scpi.py meter WHERE     identity, numeric items, a reading, the error queue of a power meter, as JSON
    scpi.py supply WHERE    levels, output, measurements and the error queue of a supply, as JSON

WHERE is tcp:PORT or the path of a serial line, 9600 8N1. What pyvisa itself cannot read (no line end, no number) ends the program.
"""

import json
import sys

import pyvisa


def opened(where):
    kind, _, port = where.partition(":")
    name = f"TCPIP::127.0.0.1::{port}::SOCKET" if kind == "tcp" else f"ASRL{where}::INSTR"
    line = pyvisa.ResourceManager("@py").open_resource(name, read_termination="\r\n", write_termination="\n")
    line.timeout = 2000
    if kind != "tcp":
        line.baud_rate = 9600
    return line


def error(line):
    code, text = line.query("SYST:ERR?").split(",", 1)
    return [int(code), text.strip().strip('"')]


def errors_of(line, command):
    """What a command leaves in the queue, and that it is empty then."""
    line.write(command)
    return [error(line), error(line)]


def begun(line):
    line.write("*CLS")
    maker, model, serial, firmware = line.query("*IDN?").split(",")
    done = line.query("*OPC?")
    assert done == "1", done
    return {"maker": maker, "model": model, "serial": serial, "firmware": firmware, "empty": error(line)}


def meter(line):
    found = begun(line)
    line.write(":NUM:NORM:NUMB 4;ITEM1 U;ITEM2 I;ITEM3 P;ITEM4 LAMBDA")
    found["header"] = line.query(":NUM:NORM:HEAD?").split(",")
    found["values"] = line.query_ascii_values(":NUM:NORM:VAL?")
    found["one"] = line.query_ascii_values(":NUMERIC:NORMAL:VALUE? 3")[0]
    found["undefined"] = errors_of(line, "NONSENSE")
    found["illegal"] = errors_of(line, ":NUM:NORM:NUMB 99")
    return found


def supply(line):
    found = begun(line)
    line.write(":SOUR1:CURR 0.35")
    line.write(":SOUR1:VOLT 24")
    found["levels"] = line.query_ascii_values(":SOUR1:VOLT?") + line.query_ascii_values(":SOUR1:CURR?")
    line.write(":OUTP CH1,ON")
    found["on"] = line.query(":OUTP? CH1")
    found["volts"] = line.query_ascii_values(":MEAS:VOLT? CH1")[0]
    found["trips"] = line.query(":OUTP:OVP:QUES? CH1;:OUTP:OCP:QUES? CH1")
    found["illegal"] = errors_of(line, ":SOUR1:VOLT 99")
    line.write(":OUTP CH1,OFF")
    found["off"] = line.query(":OUTP? CH1")
    return found


if __name__ == "__main__":
    what, where = sys.argv[1:]
    print(json.dumps({"meter": meter, "supply": supply}[what](opened(where))))
