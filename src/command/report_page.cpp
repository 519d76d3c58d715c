#include "command/report_page.hpp"

#ifdef PLIANT_REPORT_PAGE
// The file is embedded as it is: compilers do not take a string literal this long.
asm(".pushsection .rodata\n"
    ".global pliant_report_page_begin\n"
    ".global pliant_report_page_end\n"
    "pliant_report_page_begin:\n"
    ".incbin \"" PLIANT_REPORT_PAGE
    "\"\n"
    "pliant_report_page_end:\n"
    ".byte 0\n"
    ".popsection\n");

extern "C" {
// NOLINTNEXTLINE(readability-identifier-naming): labels of the lines above
extern const char pliant_report_page_begin[], pliant_report_page_end[];
}
#endif

namespace pliant {

std::string_view report_page() {
#ifdef PLIANT_REPORT_PAGE
  return {pliant_report_page_begin, pliant_report_page_end};
#else
  return {};
#endif
}

}  // namespace pliant
