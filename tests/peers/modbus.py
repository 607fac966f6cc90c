"""pymodbus in both roles, for tests/interoperability.

    modbus.py serve-tcp             a server with MBAP frames on a free port; prints the port
    modbus.py serve-rtu PATH        a server on a serial line, 9600 8N1; prints "ready"
    modbus.py read WHERE            reads a lux meter's registers, prints them as JSON; WHERE is tcp:PORT, rtu-tcp:PORT or a path
    modbus.py drive WHERE UNIT POSITION   homes an AZ drive and moves it, prints where it is as JSON

The servers hold 3 n in holding register n, 5 n in input register n, and the lux meter of the published exchange: 132854 lx as
u32 in 0007h, in thousandths in 0002h. Every answer about register 1000 comes 0.8 s late, and register 1000 counts the
requests for it.
"""

import asyncio
import json
import logging
import sys
import time

from pymodbus import FramerType
from pymodbus.client import ModbusSerialClient, ModbusTcpClient
from pymodbus.datastore import ModbusDeviceContext, ModbusSequentialDataBlock, ModbusServerContext
from pymodbus.server import ModbusSerialServer, ModbusTcpServer

# The data blocks are deprecated, which it says at every start.
logging.disable(logging.WARNING)

LUX = 132854
UNIT = 1


class Slow:
    """Register 1000 counts how often it was asked for, and every answer about it is late."""

    about = None
    asked = 0

    def trace(self, sending, pdu):
        if not sending:
            self.about = pdu.address
        elif self.about == 1000:
            self.asked += 1
            pdu.registers = [self.asked]
            time.sleep(0.8)
        return pdu


def context():
    holding = [3 * n % 65536 for n in range(2000)]
    for at, value in ((7, LUX), (2, LUX * 1000)):
        holding[at], holding[at + 1] = value >> 16, value & 0xFFFF
    # Registers begin at address 1 of the block: the context adds one.
    inputs = [5 * n % 65536 for n in range(2000)]
    return ModbusServerContext(
        devices={
            UNIT: ModbusDeviceContext(
                di=ModbusSequentialDataBlock(1, [n % 7 == 0 for n in range(2000)]),
                co=ModbusSequentialDataBlock(1, [n % 3 == 0 for n in range(2000)]),
                hr=ModbusSequentialDataBlock(1, holding),
                ir=ModbusSequentialDataBlock(1, inputs),
            )
        },
        single=False,
    )


async def serve_tcp():
    server = ModbusTcpServer(context(), address=("127.0.0.1", 0), trace_pdu=Slow().trace)
    await server.serve_forever(background=True)
    print(server.transport.sockets[0].getsockname()[1], flush=True)
    await asyncio.Event().wait()


async def serve_rtu(path):
    server = ModbusSerialServer(context(), port=path, baudrate=9600, parity="N", stopbits=1, trace_pdu=Slow().trace)
    await server.serve_forever(background=True)
    print("ready", flush=True)
    await asyncio.Event().wait()


def client(where):
    kind, _, port = where.partition(":")
    if kind == "tcp":
        made = ModbusTcpClient("127.0.0.1", port=int(port))
    elif kind == "rtu-tcp":
        made = ModbusTcpClient("127.0.0.1", port=int(port), framer=FramerType.RTU)
    else:
        made = ModbusSerialClient(where, baudrate=9600, parity="N", stopbits=1)
    assert made.connect(), where
    return made


def long(registers):
    value = registers[0] << 16 | registers[1]
    return value - (1 << 32) if value >> 31 else value


def words(*longs):
    return [word for value in longs for word in ((value >> 16) & 0xFFFF, value & 0xFFFF)]


def read(where):
    line = client(where)
    lux = line.read_holding_registers(7, count=2, device_id=UNIT)
    thousandths = line.read_input_registers(2, count=2, device_id=UNIT)
    absent = line.read_holding_registers(100, count=1, device_id=UNIT)
    refused = line.write_register(7, 1, device_id=UNIT)
    print(
        json.dumps(
            {
                "lx": long(lux.registers),
                "thousandths": long(thousandths.registers),
                "absent": absent.exception_code,
                "refused": refused.exception_code,
            }
        )
    )


def drive(where, unit, position):
    line = client(where)

    def get(at, count=2):
        answer = line.read_holding_registers(at, count=count, device_id=unit)
        assert not answer.isError(), (hex(at), answer)
        return answer.registers

    def put(at, *longs):
        answer = line.write_registers(at, words(*longs), device_id=unit)
        assert not answer.isError(), (hex(at), answer)

    def rest():
        while get(0x0178)[1] >> 6 & 1:
            time.sleep(0.02)

    before = long(get(0x00CC))
    put(0x007C, 1 << 4)
    time.sleep(0.1)
    rest()
    put(0x007C, 0)
    upper, lower = get(0x0178)
    homed = upper & 3 == 3 and lower >> 10 & 1 == 1
    put(0x0058, 0, 1, position, 2_000_000, 1_000_000, 1_000_000, 1000, 1)
    time.sleep(0.1)
    rest()
    assert not line.write_register(0x007D, 0x20, device_id=unit).isError()
    assert not line.write_register(0x007D, 0, device_id=unit).isError()
    look = get(0x00C6, 8)
    print(
        json.dumps(
            {
                "before": before,
                "homed": homed,
                "command": long(look[0:2]),
                "detected": long(look[6:8]),
                "alarm": long(get(0x0080)),
                "limits": [long(get(0x038A)), long(get(0x0388))],
            }
        )
    )


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["serve-tcp"]:
            asyncio.run(serve_tcp())
        case ["serve-rtu", path]:
            asyncio.run(serve_rtu(path))
        case ["read", where]:
            read(where)
        case ["drive", where, unit, position]:
            drive(where, int(unit), int(position))
        case _:
            sys.exit(__doc__)
