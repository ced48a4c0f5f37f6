// Draco mesh streams of version 2.2 in files that others made: .drc files, and streams in glTF's buffers.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/support/corpus_folder.h"

namespace psplit {

// Calls visit(file, stream) with each stream of the corpus, and records their number. A stream ends where the
// next one begins, so other bytes may follow it. Without a corpus the test is skipped.
template <typename Visit>
void for_each_corpus_stream(Visit visit) {
  const std::filesystem::path corpus = corpus_folder();
  if (!std::filesystem::exists(corpus)) GTEST_SKIP() << "no corpus at " << corpus;
  constexpr std::array<uint8_t, 8> kFront = {'D', 'R', 'A', 'C', 'O', 2, 2, 1};
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(corpus)) {
    if (!entry.is_regular_file() || entry.path().string().find("malformed") != std::string::npos) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    auto at = std::search(bytes.begin(), bytes.end(), kFront.begin(), kFront.end());
    while (at != bytes.end()) {
      const auto end = std::search(at + 1, bytes.end(), kFront.begin(), kFront.end());
      visit(entry.path().filename().string(), std::vector<uint8_t>(at, end));
      at = end;
      ++count;
    }
  }
  EXPECT_GT(count, 2);
  testing::Test::RecordProperty("streams", count);
}

}  // namespace psplit
