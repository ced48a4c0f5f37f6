// libstdc++ converts the chars of a path by a facet that knows only the C locale, and so no UTF-8. A program
// that defines the members of the facet, and is linked with the static library, has them in the place of the
// library's. Include it in one file that every program has. Elsewhere the manifest of the program decides.
#pragma once

#include <codecvt>
#include <locale>

#ifdef __GLIBCXX__
namespace std {
namespace {

constexpr char32_t kReplacement = 0xfffd;

// Reads one character of UTF-8. A byte that begins none is the replacement character: a path is never refused.
char32_t read_character(const char*& from, const char* end) {
  const auto first = static_cast<unsigned char>(*from++);
  if (first < 0x80) return first;
  const int more = first >= 0xf0 && first < 0xf5   ? 3
                   : first >= 0xe0 && first < 0xf0 ? 2
                   : first >= 0xc2 && first < 0xe0 ? 1
                                                   : 0;
  char32_t character = first & (0x3fu >> more);
  const char* at = from;
  for (int i = 0; i < more; ++i, ++at) {
    if (at == end || (static_cast<unsigned char>(*at) & 0xc0) != 0x80) return kReplacement;
    character = character << 6 | (static_cast<unsigned char>(*at) & 0x3f);
  }
  constexpr char32_t kLeast[] = {0x80, 0x80, 0x800, 0x10000};
  const bool is_surrogate = character >= 0xd800 && character < 0xe000;
  if (more == 0 || character < kLeast[more] || character > 0x10ffff || is_surrogate) return kReplacement;
  from = at;
  return character;
}

}  // namespace

using WideFacet = codecvt<wchar_t, char, mbstate_t>;

codecvt_base::result WideFacet::do_in(state_type&, const extern_type* from, const extern_type* from_end,
                                      const extern_type*& from_next, intern_type* to, intern_type* to_end,
                                      intern_type*& to_next) const {
  from_next = from;
  to_next = to;
  while (from_next != from_end) {
    const extern_type* next = from_next;
    const char32_t character = read_character(next, from_end);
    const bool is_pair = character >= 0x10000;
    if (to_end - to_next < (is_pair ? 2 : 1)) return partial;
    if (is_pair) *to_next++ = static_cast<wchar_t>(0xd7c0 + (character >> 10));
    *to_next++ = static_cast<wchar_t>(is_pair ? 0xdc00 + (character & 0x3ff) : character);
    from_next = next;
  }
  return ok;
}

codecvt_base::result WideFacet::do_out(state_type& state, const intern_type* from, const intern_type* from_end,
                                       const intern_type*& from_next, extern_type* to, extern_type* to_end,
                                       extern_type*& to_next) const {
  return codecvt_utf8_utf16<wchar_t>().out(state, from, from_end, from_next, to, to_end, to_next);
}

int WideFacet::do_length(state_type&, const extern_type* from, const extern_type* end, size_t most) const {
  const extern_type* at = from;
  for (size_t units = 0; at != end;) {
    const extern_type* next = at;
    units += read_character(next, end) >= 0x10000 ? 2 : 1;
    if (units > most) break;
    at = next;
  }
  return static_cast<int>(at - from);
}

int WideFacet::do_encoding() const throw() { return 0; }

int WideFacet::do_max_length() const throw() { return 4; }

}  // namespace std
#endif
