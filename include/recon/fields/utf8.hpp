// Names in UTF-8, as files that are written need them.
#pragma once

#include <string>
#include <string_view>

namespace recon {

// Whether the text is well-formed UTF-8 that XML can hold: no overlong forms, no surrogates,
// nothing beyond U+10FFFF, neither U+FFFE nor U+FFFF. (Control characters of one byte are
// not looked at.)
bool is_utf8(std::string_view text);

// The text itself where it is UTF-8; else its bytes are read as Windows-1252, which is Latin-1 with
// letters and quotes in place of the control characters from 0x80 on.
std::string to_utf8(std::string_view text);

}  // namespace recon
