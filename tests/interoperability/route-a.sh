#!/usr/bin/env bash
# A kernel with USB in an emulated machine: the twins of the USB spectrometers, attached by vhci-hcd, are read through the real
# libusb; hotplug, reset, replug and a claim by another program are tried. For people: it downloads a kernel of 70 MB and is no
# part of the check. Needs Debian packages qemu-system-x86 busybox-static kmod cpio python3, and no root.
#
#     cargo build -p isolux -p isolux-interoperability && tests/interoperability/route-a.sh
#
# KERNEL=VERSION takes another package linux-image-VERSION; LIMIT=SECONDS another end than 900 s.
set -euo pipefail
cd "$(dirname "$0")/../.."
top=$PWD
home=target/route-a
for tool in qemu-system-x86_64 busybox depmod cpio dpkg-deb python3; do
  command -v "$tool" >/dev/null || PATH=$PATH:/usr/sbin:/sbin
  command -v "$tool" >/dev/null || { echo "$tool is missing: apt-get install qemu-system-x86 busybox-static kmod cpio python3" >&2; exit 1; }
done
for program in isolux isolux-usb-client; do
  [ -x "target/debug/$program" ] || { echo "target/debug/$program is missing: cargo build -p isolux -p isolux-interoperability" >&2; exit 1; }
done

# The kernel that the distribution has now; old ones leave its mirror. It is unpacked, not installed.
kernel=${KERNEL:-$(apt-cache depends linux-image-amd64 | sed -n 's/.*Depends: linux-image-//p' | head -1)}
if [ ! -d "$home/$kernel" ]; then
  mkdir -p "$home/download"
  (cd "$home/download" && apt-get download "linux-image-$kernel")
  dpkg-deb -x "$home"/download/linux-image-"$kernel"_*.deb "$home/$kernel.part"
  depmod -b "$home/$kernel.part" "$kernel"
  mv "$home/$kernel.part" "$home/$kernel"
fi

# An initial file system of busybox and the modules that mount this machine's files, read only, and make a USB host.
root=$home/root
rm -rf "$root"
mkdir -p "$root"/{bin,proc,sys,dev,host,modules}
cp "$(command -v busybox)" "$root/bin/busybox"
modules=(virtio_pci 9pnet_virtio 9p vhci-hcd)
: > "$root/modules/order"
for module in "${modules[@]}"; do
  modprobe -d "$home/$kernel" -S "$kernel" --show-depends "$module" | awk '$1 == "insmod" { print $2 }' | while read -r file; do
    cp -n "$file" "$root/modules/"
    grep -qx "$(basename "$file")" "$root/modules/order" || basename "$file" >> "$root/modules/order"
  done
done
cat > "$root/init" <<INIT
#!/bin/busybox sh
/bin/busybox --install -s /bin
mount -t proc none /proc; mount -t sysfs none /sys; mount -t devtmpfs none /dev
while read -r module; do insmod "/modules/\$module"; done < /modules/order
mount -t 9p -o trans=virtio,version=9p2000.L,ro,msize=262144 host /host
mount -t proc none /host/proc; mount -t sysfs none /host/sys; mount -o bind /dev /host/dev; mount -t tmpfs none /host/tmp
mkdir -p /host/tmp/run; mount -t tmpfs none /host/run; mkdir -p /host/run/lock
ip link set lo up
chroot /host /bin/bash "$top/tests/interoperability/route-a-guest.sh" "$top"
echo "route A ended with \$?"
poweroff -f
INIT
chmod +x "$root/init"
(cd "$root" && find . | cpio -o -H newc --quiet) > "$home/initrd"

# Emulated even where /dev/kvm exists: a virtual machine that is one itself may not boot by it.
timeout "${LIMIT:-900}" qemu-system-x86_64 -accel tcg -cpu max -M pc -smp 1 -m 1024 -nographic -no-reboot -nic none \
  -kernel "$home/$kernel/boot/vmlinuz-$kernel" -initrd "$home/initrd" -append "console=ttyS0 quiet panic=-1" \
  -virtfs local,path=/,mount_tag=host,security_model=none,readonly=on,multidevs=remap | tee "$home/log"
grep -q "route A ended with 0" "$home/log"
