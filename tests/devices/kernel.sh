#!/usr/bin/env bash
# A kernel with ALSA's sequencer, USB-MIDI and sound cards, for machines whose own has none: Debian's, in QEMU's emulation of a processor, with this
# machine's files to read. Nothing is installed.
#
#   tests/devices/kernel.sh prepare              fetches QEMU and the kernel through apt-get, into FOLDER; exit code 3 where they cannot be had
#   tests/devices/kernel.sh run COMMAND [ARG]..  boots (some 10 s), runs the command there as root, gives its exit code
#
# FOLDER is $PACINIAN_KERNEL, or a folder of this user's in the temporary one. SECONDS_ALLOWED (300) ends what takes longer. Inside, /mnt and /run can be written
# to, and are gone afterwards. PACINIAN_EMULATED is set there: nobody hears the cards, and they may be pulled.
set -euo pipefail

folder=${PACINIAN_KERNEL:-${TMPDIR:-/tmp}/pacinian-kernel-$(id -u)}
modules='virtio_pci 9pnet_virtio 9p snd-seq snd-seq-midi snd-hrtimer snd-usb-audio xhci-pci dummy_hcd libcomposite usb_f_midi'

# What was unpacked, and not installed, is found.
use_unpacked() {
  export PATH="$folder/unpacked/usr/bin:$folder/unpacked/bin:$folder/unpacked/sbin:$PATH"
  export LD_LIBRARY_PATH="$folder/unpacked/usr/lib/x86_64-linux-gnu:$folder/unpacked/lib/x86_64-linux-gnu"
  export QEMU_MODULE_DIR="$folder/unpacked/usr/lib/x86_64-linux-gnu/qemu"
}

fetch() {
  [[ $(uname -m) == x86_64 ]] || { echo "kernel.sh: made for x86-64" >&2; exit 3; }
  mkdir -p "$folder/cache/archives/partial" "$folder/unpacked" "$folder/kernel"
  cd "$folder"
  local image
  image=$(apt-cache depends linux-image-amd64 | sed -n 's/^ *Depends: \(linux-image-[0-9].*\)$/\1/p' | head -n 1)
  [[ -n $image ]] || { echo "kernel.sh: apt-cache knows no linux-image-amd64; apt-get update" >&2; exit 3; }
  {
    # What is installed already is fetched as well.
    apt-get install --yes --no-install-recommends --download-only --reinstall -o Debug::NoLocking=1 -o Dir::Cache="$folder/cache" \
      qemu-system-x86 busybox-static kmod cpio && (cd kernel && apt-get download "$image")
  } > fetched.log 2>&1 || {
    echo 'kernel.sh: apt-get cannot fetch QEMU or the kernel' >&2
    tail -n 5 fetched.log >&2
    exit 3
  }
  for package in cache/archives/*.deb; do dpkg-deb --extract "$package" unpacked; done
  dpkg-deb --extract kernel/"$image"_*.deb kernel
  rm -rf cache kernel/*.deb
  use_unpacked
  pack
}

# The first files of the kernel: its modules, and what loads them and goes on to this machine's files.
pack() {
  local version first=$folder/first module
  version=$(ls "$folder/kernel/lib/modules")
  rm -rf "$first"
  mkdir -p "$first"/{bin,proc,sys,dev,host}
  cp "$(command -v busybox)" "$first/bin/"
  for word in sh mount modprobe chroot cat mkdir poweroff echo; do ln -s busybox "$first/bin/$word"; done
  kmod_as depmod -b "$folder/kernel" "$version"
  for module in $modules; do
    kmod_as modprobe -d "$folder/kernel" -S "$version" --show-depends "$module" 2> /dev/null | sed -n 's/^insmod \([^ ]*\).*/\1/p'
  done | sort -u | while read -r path; do
    mkdir -p "$first/$(dirname "${path#"$folder/kernel/"}")"
    cp "$path" "$first/${path#"$folder/kernel/"}"
  done
  cp "$folder/kernel/lib/modules/$version"/modules.{order,builtin,builtin.modinfo} "$first/lib/modules/$version/"
  kmod_as depmod -b "$first" "$version"
  printf '%s\n' "$modules" > "$first/modules"
  cat > "$first/init" << 'INIT'
#!/bin/sh
mount -t proc none /proc
mount -t sysfs none /sys
mount -t devtmpfs none /dev
for module in $(cat /modules); do modprobe $module; done
mount -t 9p -o ro,trans=virtio,version=9p2000.L,msize=512000,cache=loose files /host
mount -t devtmpfs none /host/dev
mount -t proc none /host/proc
mount -t sysfs none /host/sys
for folder in run mnt; do mount -t tmpfs none /host/$folder; done
mkdir -p /host/dev/shm /host/dev/pts /host/run/result
mount -t tmpfs none /host/dev/shm
mount -t devpts none /host/dev/pts
mount -t 9p -o trans=virtio,version=9p2000.L,msize=512000 result /host/run/result
mount -t configfs none /host/sys/kernel/config 2> /dev/null
chroot /host /bin/bash /run/result/command > /host/run/result/output 2>&1
echo $? > /host/run/result/code
poweroff -f
INIT
  chmod +x "$first/init"
  (cd "$first" && find . | cpio --create --format=newc --quiet | gzip -1) > "$folder/first.gz"
}

# kmod does what it is called.
kmod_as() {
  ln -sf "$(command -v kmod)" "$folder/$1"
  "$folder/$@"
}

run() {
  use_unpacked
  local result machine code
  result=$(mktemp -d "$folder/result.XXXXXX")
  {
    printf 'export PACINIAN_EMULATED=1 HOME=/mnt TMPDIR=/mnt PATH=%q\n' /usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
    printf 'cd %q || exit 3\n' "$PWD"
    printf '%q ' "$@"
    printf '\n'
  } > "$result/command"
  local qemu=$folder/unpacked/usr/bin/qemu-system-x86_64 firmware=("$folder/unpacked/usr/share/qemu" "$folder/unpacked/usr/share/seabios" "$folder/unpacked/usr/lib/ipxe/qemu")
  timeout "${SECONDS_ALLOWED:-300}" "$qemu" -L "${firmware[0]}" -L "${firmware[1]}" -L "${firmware[2]}" \
    -accel tcg,thread=multi -cpu max -m 1024 -smp 2 -display none -no-reboot -serial "file:$result/console" -monitor none \
    -kernel "$folder"/kernel/boot/vmlinuz-* -initrd "$folder/first.gz" -append 'console=ttyS0 quiet panic=-1 tsc=reliable clocksource=tsc' \
    -audiodev none,id=sound -device qemu-xhci -device usb-audio,audiodev=sound,multi=on \
    -fsdev local,id=files,path=/,security_model=none,readonly=on,multidevs=remap -device virtio-9p-pci,fsdev=files,mount_tag=files \
    -fsdev local,id=result,path="$result",security_model=none -device virtio-9p-pci,fsdev=result,mount_tag=result \
    < /dev/null > "$result/machine" 2>&1 || machine=$?
  if [[ ! -e $result/code ]]; then
    echo "kernel.sh: the kernel did not come to an end (QEMU: ${machine:-0})" >&2
    tail -n 20 "$result/machine" "$result/console" >&2 || true
    cat "$result/output" 2> /dev/null || true
    rm -rf "$result"
    exit 4
  fi
  code=$(cat "$result/code")
  cat "$result/output"
  rm -rf "$result"
  exit "$code"
}

case ${1:-} in
  prepare) fetch ;;
  run)
    shift
    [[ -e $folder/first.gz ]] || { echo "kernel.sh: not prepared: $0 prepare" >&2; exit 3; }
    run "$@"
    ;;
  *)
    sed -n '2,10s/^# \{0,1\}//p' "$0"
    exit 2
    ;;
esac
