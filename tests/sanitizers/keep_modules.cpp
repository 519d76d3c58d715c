// Modules that libraries load stay until the end of a sanitized test, so that what leaked has a name then.

extern "C" int dlclose(void* /*module*/) noexcept {
  return 0;
}
