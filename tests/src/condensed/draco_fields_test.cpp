// A stream that libdraco's encoder wrote comes back from its fields bit for bit.
#include "src/condensed/draco_fields.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/support/draco_features.h"
#include "tests/support/draco_streams.h"

namespace psplit {
namespace {

TEST(DracoFields, EveryStreamComesBack) {
  size_t count = 0, without_fields = 0;
  std::map<std::string, size_t> messages;
  for_each_draco_stream(
      [&](const DracoStream& stream) {
        ++count;
        const Expected<DracoFields> fields = read_fields(stream.bytes);
        if (!fields) {
          ++messages[fields.status().message()];
          ++without_fields;
          return;
        }
        const Expected<std::vector<uint8_t>> again = write_fields(*fields);
        ASSERT_TRUE(again.ok()) << stream.name << again.status().message();
        if (*again != stream.bytes) {
          size_t at = 0;
          while (at < again->size() && at < stream.bytes.size() && (*again)[at] == stream.bytes[at]) ++at;
          if (messages["differs"]++ < 20)
            ADD_FAILURE() << stream.name << ": " << stream.bytes.size() << " bytes, " << again->size()
                          << " written, first difference at " << at << " levels " << fields->possible_levels;
        }
        if (!fields->symbol_lists[0].empty()) {
          DracoFields copy = *fields;
          EXPECT_TRUE(list_symbols(copy).ok());
          EXPECT_EQ(copy.symbol_lists, fields->symbol_lists);
        }
      },
      StreamSet::kAll);
  for (const auto& [message, n] : messages) printf("%zu: %s\n", n, message.c_str());
  printf("%zu streams, %zu without fields\n", count, without_fields);
}

}  // namespace
}  // namespace psplit
