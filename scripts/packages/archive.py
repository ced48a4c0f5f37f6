"""Archives whose bytes do not depend on the file system, the user or the umask that they were made with."""
import datetime, gzip, tarfile, zipfile


def mode(old):
    """Of files that only their owner may change, and everybody may read and, if the owner may, run."""
    return 0o755 if old & 0o100 else 0o644


def sort_tar(made, placed):
    with tarfile.open(made) as old, open(placed, "wb") as file, \
            gzip.GzipFile(filename="", mode="wb", fileobj=file, mtime=0) as packed, tarfile.open(fileobj=packed, mode="w") as new:
        for member in sorted(old.getmembers(), key=lambda member: member.name):
            member.uid = member.gid = 0
            member.uname = member.gname = "root"
            member.mode = mode(member.mode)
            new.addfile(member, old.extractfile(member) if member.isfile() else None)


def sort_zip(made, placed, seconds):
    when = datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc).timetuple()[:6]
    with zipfile.ZipFile(made) as old, zipfile.ZipFile(placed, "w", zipfile.ZIP_DEFLATED) as new:
        for name in sorted(name for name in old.namelist() if not name.endswith("/")):
            entry = zipfile.ZipInfo(name, when)
            entry.create_system = 3  # so that the next line has modes of POSIX
            entry.external_attr = (0o100000 | mode(old.getinfo(name).external_attr >> 16)) << 16
            new.writestr(entry, old.read(name), zipfile.ZIP_DEFLATED)


def sort(made, placed, seconds):
    """Writes the archive `made`, .tar.gz or .zip, to `placed` with sorted names. A .zip gets a time in seconds since 1970; cpack
    gives a .tar.gz that of $SOURCE_DATE_EPOCH."""
    if made.suffix == ".zip":
        sort_zip(made, placed, seconds)
    else:
        sort_tar(made, placed)
