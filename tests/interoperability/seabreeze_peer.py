"""Ocean's own compiled library (cseabreeze in seabreeze 2.11) reads a spectrometer; what it found as one line of JSON.

    python seabreeze_peer.py INTEGRATION_US

Runs below the bridge (tests/interoperability/bridge.c), where its libusb sees the twin.
"""

import json
import sys

import seabreeze

seabreeze.use("cseabreeze")
from seabreeze.spectrometers import Spectrometer  # noqa: E402

found = {}
try:
    spectrometer = Spectrometer.from_first_available()
    try:
        found["model"] = spectrometer.model
        found["serial"] = spectrometer.serial_number
        wavelengths = spectrometer.wavelengths()
        found["pixels"] = len(wavelengths)
        found["first_nm"], found["last_nm"] = float(wavelengths[0]), float(wavelengths[-1])
        found["nonlinearity"] = [float(c) for c in spectrometer.f.nonlinearity_coefficients.get_nonlinearity_coefficients()]
        found["limits_us"] = list(spectrometer.integration_time_micros_limits)
        spectrometer.integration_time_micros(int(sys.argv[1]))
        spectrometer.intensities()  # the first after a change is of the old time
        found["counts"] = [float(count) for count in spectrometer.intensities()]
    finally:
        spectrometer.close()
except Exception as error:  # what it says is the answer
    found["error"] = f"{type(error).__name__}: {error}"
print(json.dumps(found))
