// Runs `gltf-psplit batch` as a process of its own, in a folder of the test.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

#include "tests/tools/batch/batch_files.h"
#include "tests/tools/command_file.h"

namespace psplit {

class BatchJobs : public BatchFiles {
 protected:
  // Starts a shell in the test's folder. It knows the command as $P.
  pid_t start(const std::string& words) const {
    const pid_t child = fork();
    if (child != 0) return child;
    if (chdir(folder_.path().c_str()) != 0) _exit(98);
    setenv("P", command_file(), 1);
    const std::string script = words + " >out.txt 2>err.txt";
    execl("/bin/sh", "sh", "-c", script.c_str(), static_cast<char*>(nullptr));
    _exit(99);
  }
  int wait_for(pid_t child) {
    int status = 0;
    waitpid(child, &status, 0);
    out_ = read_bytes(path("out.txt"));
    err_ = read_bytes(path("err.txt"));
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }
  int shell(const std::string& words) { return wait_for(start(words)); }
};

}  // namespace psplit
