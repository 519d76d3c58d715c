/// A file with given bytes, for readers that open files themselves.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <unistd.h>

namespace pliant::fuzz {

/// In memory where the system has a place for that; gone with the object.
class BytesInFile {
 public:
  BytesInFile(std::string_view bytes, const char* extension) {
    const std::filesystem::path memory = "/dev/shm";
    const auto place = std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path();
    path_ = place / ("pliant_fuzz_" + std::to_string(getpid()) + extension);
    std::ofstream(path_, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }
  ~BytesInFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  BytesInFile(const BytesInFile&) = delete;
  BytesInFile& operator=(const BytesInFile&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace pliant::fuzz
