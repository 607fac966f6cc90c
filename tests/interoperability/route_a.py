"""What the emulated machine of route-a.sh does to USB devices: attach PORT VHCI-PORT, reset PRODUCT, claim PRODUCT FILE."""

import fcntl
import glob
import os
import pathlib
import socket
import struct
import sys
import time

RESET = 0x5514  # USBDEVFS_RESET
CLAIM = 0x8004550F  # USBDEVFS_CLAIMINTERFACE


def attach(port, vhci_port):
    """Asks the twin for its device 1-1 (USB/IP 1.1.1, OP_REQ_IMPORT) and hands the connection to the kernel."""
    link = socket.create_connection(("127.0.0.1", int(port)))
    link.sendall(struct.pack(">HHI32s", 0x0111, 0x8003, 0, b"1-1"))
    reply = b""
    while len(reply) < 320:
        more = link.recv(320 - len(reply))
        if not more:
            sys.exit(f"the twin refuses: {reply!r}")
        reply += more
    _, _, status = struct.unpack(">HHI", reply[:8])
    bus, device, speed = struct.unpack(">III", reply[8 + 256 + 32 : 8 + 256 + 32 + 12])
    if status:
        sys.exit(f"the twin refuses: {status}")
    words = f"{vhci_port} {link.fileno()} {bus << 16 | device} {speed}"
    pathlib.Path("/sys/devices/platform/vhci_hcd.0/attach").write_text(words)


def node(product):
    for found in glob.glob("/sys/bus/usb/devices/*/idProduct"):
        if pathlib.Path(found).read_text().strip() == product:
            folder = pathlib.Path(found).parent
            bus, device = (int((folder / name).read_text()) for name in ("busnum", "devnum"))
            return os.open(f"/dev/bus/usb/{bus:03}/{device:03}", os.O_RDWR)
    sys.exit(f"no device {product}")


def reset(product):
    fcntl.ioctl(node(product), RESET)


def claim(product, file):
    fcntl.ioctl(node(product), CLAIM, struct.pack("I", 0))
    pathlib.Path(file).touch()
    time.sleep(100)


{"attach": attach, "reset": reset, "claim": claim}[sys.argv[1]](*sys.argv[2:])
