// Decodes a .drc file to libdraco's classes, by libdraco and by psplit. scripts/libdraco runs it.
//
//   draco_classes_benchmark warm FILE ROUNDS
//     the least milliseconds of processor time of each, in turn
//   draco_classes_benchmark libdraco|psplit FILE
//     the first decode of the process: its milliseconds and page faults, and the largest resident memory in KiB
#include <sys/resource.h>

#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

#include "psplit/draco_decoder.h"

namespace {

template <typename Decoder>
double decode_ms(const std::vector<char>& file) {
  const std::clock_t begin = std::clock();  // processor time: other programs disturb it less
  draco::DecoderBuffer buffer;
  buffer.Init(file.data(), file.size());
  Decoder decoder;
  const auto decoded = decoder.DecodePointCloudFromBuffer(&buffer);
  if (!decoded.ok()) {
    std::cerr << decoded.status().error_msg() << "\n";
    std::exit(3);
  }
  return 1000.0 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() < 2) return 1;
  std::ifstream stream(arguments[1], std::ios::binary);
  const std::vector<char> file{std::istreambuf_iterator<char>(stream), {}};
  if (arguments[0] == "warm") {
    double libdraco = 1e30, psplit = 1e30;
    for (int round = 0; round < std::stoi(arguments.at(2)); ++round) {
      libdraco = std::min(libdraco, decode_ms<draco::Decoder>(file));
      psplit = std::min(psplit, decode_ms<psplit::DracoDecoder>(file));
    }
    std::cout << libdraco << " " << psplit << "\n";
    return 0;
  }
  rusage before{}, after{};
  getrusage(RUSAGE_SELF, &before);
  const double ms =
      arguments[0] == "psplit" ? decode_ms<psplit::DracoDecoder>(file) : decode_ms<draco::Decoder>(file);
  getrusage(RUSAGE_SELF, &after);
  std::cout << ms << " " << after.ru_minflt - before.ru_minflt << " " << after.ru_maxrss << "\n";
}
