#!/usr/bin/env python3
"""Ctrl-C on a console stops the command for Windows, and nothing is left that it was writing:

    ctrl_c_test.py WINE COMMAND.exe

wine makes a console of a terminal of this system. A program that has not begun yet is ended by wine itself, so the tests wait
until the command writes its first file."""
import os, pathlib, pty, re, select, shutil, signal, subprocess, sys, tempfile, time

MAY_PASS = 75  # the exit code of what may pass if it is tried again
wine, program = sys.argv[1], str(pathlib.Path(sys.argv[2]).resolve())


def run(folder, *words):
    return subprocess.run([wine, program, *words], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True)


def press_ctrl_c(folder, may_press, *words):
    """Runs the command on a terminal of its own, presses Ctrl-C once `may_press()`, and returns the exit code and the text."""
    child, terminal = pty.fork()
    if child == 0:
        os.chdir(folder)
        os.execv(wine, [wine, program, *words])
    text, pressed, ended, end = b"", False, 0, time.monotonic() + 120

    def read(seconds):
        nonlocal text
        if not select.select([terminal], [], [], seconds)[0]:
            return False
        try:
            text += os.read(terminal, 1 << 16)
        except OSError:  # its last process has ended
            return False
        return True

    while not ended:
        if time.monotonic() > end:
            os.kill(child, signal.SIGKILL)
        read(0.02)
        if not pressed and may_press():
            os.write(terminal, b"\x03")
            pressed = True
        ended, status = os.waitpid(child, os.WNOHANG)
    while read(0.2):  # not to its end: the console may stay when the command has ended
        pass
    os.close(terminal)
    code = os.waitstatus_to_exitcode(status)
    return code, re.sub(rb"\x1b\[[?0-9;]*[A-Za-z]", b"", text).decode(errors="replace")


def says(text, pattern):
    """Whether the terminal shows what `pattern` describes. Blanks do not count: the console draws them by moving its cursor, and
    begins a new line where its last column is reached, in the middle of a word, too."""
    return re.search(pattern.replace(" ", ""), "".join(text.split()))


def expect(true, *what):
    if not true:
        sys.exit(" ".join(map(str, what)))


def a_command_ends(folder):
    begun = lambda: any(file.stat().st_size > 1 << 20 for file in folder.iterdir())
    code, text = press_ctrl_c(folder, begun, "generate", "a.glb", "--shape", "terrain", "--faces", "20000000")
    expect(code == MAY_PASS, "generate exits with", code, text)
    expect(says(text, "error: stopped by a signal"), text)
    expect(not list(folder.iterdir()), "left:", list(folder.iterdir()))


def a_batch_goes_on_later(folder):
    # Some seconds of work are left when the first asset is there: this machine may be busy.
    count = 16
    (folder / "in").mkdir()
    done = run(folder, "generate", "in/0.glb", "--shape", "terrain", "--faces", "200000", "-q")
    expect(done.returncode == 0, done.stderr)
    for number in range(1, count):
        shutil.copy(folder / "in/0.glb", folder / f"in/{number}.glb")
    out = folder / "done"
    batch = ["batch", "in", "-o", "done", "-q"]
    code, text = press_ctrl_c(folder, lambda: len(list(out.glob("*.glb"))) > 0, *batch)
    made = len(list(out.glob("*.glb")))
    expect(code == MAY_PASS, "batch exits with", code, "after", made, "assets:", text)
    expect(says(text, r"stopped by a signal after \d+ assets?; run the command again to continue"), text)
    expect(0 < made < count, made, "assets were made before it stopped")
    done = run(folder, *batch)
    expect(done.returncode == 0 and len(list(out.glob("*.glb"))) == count, done.returncode, done.stderr)


for test in a_command_ends, a_batch_goes_on_later:
    with tempfile.TemporaryDirectory() as name:
        test(pathlib.Path(name))
print("Ctrl-C: 2 tests passed")
