#include "base/error.hpp"
#include "fuzz/files.hpp"
#include "fuzz/targets.hpp"
#include "io/checkpoint_file.hpp"
#include "petsc/check.hpp"

#include <array>
#include <zlib.h>

#include <fmt/format.h>

namespace pliant::fuzz {
namespace {

constexpr std::size_t header_size = 512;  // as docs/restart.md has it
constexpr std::int64_t num_nodes = 4;

std::string with_right_checksum(std::string_view bytes) {
  std::string text(bytes);
  if (text.size() < header_size) return text;
  const auto* behind = reinterpret_cast<const Bytef*>(text.data() + header_size);
  const unsigned long sum = crc32(crc32(0, nullptr, 0), behind, static_cast<uInt>(text.size() - header_size));
  std::string header = fmt::format("pliant-checkpoint\nversion 1\nbytes {}\ncrc32 {:08x}\n", text.size(), sum);
  header.resize(header_size, '\0');
  return text.replace(0, header_size, header);
}

ArchiveOrders orders() {
  std::vector<EntryKey> nodes;
  for (std::int64_t n = 0; n < num_nodes; ++n) nodes.push_back({n, n});
  return {{MPI_COMM_SELF, nodes}, {MPI_COMM_SELF, std::vector<EntryKey>{}}, {MPI_COMM_SELF, nodes}};
}

/// Each thing that objects keep.
void restore(Archive& archive) {
  double number = 0.0;
  std::array<double, 3> numbers{};
  Handle<Vec> q, p;
  check(VecCreateSeq(PETSC_COMM_SELF, 3 * num_nodes, q.out()));
  check(VecCreateSeq(PETSC_COMM_SELF, num_nodes, p.out()));
  const auto tried = [](const auto& exchange) {
    try {
      exchange();
    } catch (const FileError&) {
    }
  };
  tried([&] { archive.number("number", number); });
  tried([&] { archive.numbers("numbers", numbers); });
  tried([&] { archive.vector("q", Entries::nodes, q.get()); });
  tried([&] { archive.vector("p", Entries::pressures, p.get()); });
}

void read(std::string_view bytes) {
  const BytesInFile file(bytes, ".h5");
  try {
    (void)read_checkpoint_info(MPI_COMM_SELF, file.path());
    const ArchiveOrders known = orders();
    CheckpointReader reader(MPI_COMM_SELF, file.path(), known);
    restore(reader);
  } catch (const FileError&) {
  }
}

}  // namespace

void read_as_checkpoint(std::string_view bytes) {
  read(bytes);
  read(with_right_checksum(bytes));
}

}  // namespace pliant::fuzz
