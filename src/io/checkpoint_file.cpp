#include "io/checkpoint_file.hpp"

#include "base/error.hpp"
#include "base/file.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/hdf5.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <fstream>
#include <functional>
#include <system_error>
#include <utility>
#include <zlib.h>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr std::int64_t header_size = 512;  // [bytes], the smallest that HDF5 allows
constexpr int version = 5;
constexpr const char* magic = "pliant-checkpoint";

std::string header(std::int64_t size, unsigned long checksum) {
  std::string text = fmt::format("{}\nversion {}\nbytes {}\ncrc32 {:08x}\n", magic, version, size, checksum);
  text.resize(header_size, '\0');
  return text;
}

FileError unreadable(const std::filesystem::path& file, const std::string& why) {
  return FileError(fmt::format("cannot read the checkpoint '{}': {}", file.string(), why));
}

/// CRC-32 of the bytes from `begin` to `end`. Not collective.
unsigned long checksum_of(const std::filesystem::path& file, std::int64_t begin, std::int64_t end) {
  std::ifstream in(file, std::ios::binary);
  in.seekg(begin);
  std::vector<char> buffer(std::size_t{1} << 20);
  unsigned long checksum = crc32(0, nullptr, 0);
  while (begin < end) {
    const std::int64_t wanted = std::min(end - begin, std::ssize(buffer));
    if (!in.read(buffer.data(), wanted)) throw unreadable(file, "reading it failed");
    checksum = crc32(checksum, reinterpret_cast<const Bytef*>(buffer.data()), static_cast<uInt>(wanted));
    begin += wanted;
  }
  return checksum;
}

/// CRC-32 of all bytes behind the header; each rank reads its part. Collective.
unsigned long checksum_of(MPI_Comm comm, const std::filesystem::path& file, std::int64_t size) {
  const std::int64_t ranks = num_ranks(comm), part = (size - header_size + ranks - 1) / ranks;
  const std::int64_t begin = std::min(header_size + rank(comm) * part, size), end = std::min(begin + part, size);
  unsigned long mine = 0;
  on_every_rank(comm, [&] { mine = checksum_of(file, begin, end); });
  std::vector<unsigned long> parts(static_cast<std::size_t>(ranks));
  std::vector<std::int64_t> lengths(parts.size());
  const std::int64_t length = end - begin;
  check_mpi(MPI_Allgather(&mine, 1, MPI_UNSIGNED_LONG, parts.data(), 1, MPI_UNSIGNED_LONG, comm));
  check_mpi(MPI_Allgather(&length, 1, MPI_INT64_T, lengths.data(), 1, MPI_INT64_T, comm));
  unsigned long total = crc32(0, nullptr, 0);
  for (std::size_t r = 0; r < parts.size(); ++r) total = crc32_combine(total, parts[r], lengths[r]);
  return total;
}

std::int64_t size_of(const std::filesystem::path& file) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  if (error) throw unreadable(file, error.message());
  return static_cast<std::int64_t>(size);
}

std::string start_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text(header_size, '\0');
  in.read(text.data(), header_size);
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  return text;
}

void write_text(hid_t file, const std::string& name, const std::string& text) {
  const std::string doing = "write the text '" + name + "'";
  const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose, doing);
  check_hdf5(H5Tset_size(type.get(), std::max<std::size_t>(text.size(), 1)), doing);
  check_hdf5(H5Tset_cset(type.get(), H5T_CSET_UTF8), doing);
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose, doing);
  const Hdf5Handle made(H5Dcreate2(file, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                        H5Dclose, doing);
  check_hdf5(H5Dwrite(made.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str()), doing);
}

std::string read_text(hid_t file, const std::string& name) {
  const std::string doing = "read the text '" + name + "'";
  const Hdf5Handle made(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose, doing);
  const Hdf5Handle type(H5Dget_type(made.get()), H5Tclose, doing);
  const Hdf5Handle space(H5Dget_space(made.get()), H5Sclose, doing);
  if (H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) != 0 ||
      H5Sget_simple_extent_npoints(space.get()) != 1) {
    throw FileError("cannot " + doing + ": it is not a text");
  }
  require_stored(made.get(), doing);
  const std::size_t size = H5Tget_size(type.get());
  require_room(made.get(), static_cast<double>(size), doing);  // a chunked dataset may be shorter than its size
  std::string text(size, '\0');
  check_hdf5(H5Dread(made.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()), doing);
  text.resize(std::min(text.size(), text.find('\0')));
  return text;
}

void start_file(const std::filesystem::path& path, const CheckpointInfo& info) {
  const QuietHdf5 quiet;
  const std::string doing = "write '" + path.string() + "'";
  File(path, FileMode::anew).reserve(0, 256 * 1024 + std::ssize(info.input));  // HDF5 does not survive a full disk
  Hdf5Handle file = open_hdf5(path, Hdf5Mode::create, header_size);
  write_attribute(file.get(), "format", std::string(magic));
  write_attribute(file.get(), "version", std::int64_t{version});
  write_attribute(file.get(), "step", info.step);
  write_attribute(file.get(), "time", info.time);
  write_attribute(file.get(), "title", info.title);
  write_attribute(file.get(), "mesh", info.mesh);
  write_attribute(file.get(), "program", info.program);
  write_attribute(file.get(), "petsc_options", info.petsc_options);
  write_attribute(file.get(), "ranks", info.ranks);
  write_text(file.get(), "input", info.input);
  file.close(doing);
}

}  // namespace

const GlobalOrder& ArchiveOrders::of(Entries entries) const {
  switch (entries) {
    case Entries::nodes:
      return nodes;
    case Entries::internal:
      return internal;
    case Entries::pressures:
      break;
  }
  return pressures;
}

int ArchiveOrders::components_of(Entries entries) const {
  switch (entries) {
    case Entries::nodes:
      return 3;
    case Entries::internal:
      return internal_components;
    case Entries::pressures:
      break;
  }
  return 1;
}

void CheckpointWriter::exchange(const std::string& path, std::span<double> x) {
  numbers_.push_back({path, {x.begin(), x.end()}});
}

void CheckpointWriter::exchange(const std::string& path, Entries entries, Vec x) {
  const GlobalOrder& order = orders_.of(entries);
  const int components = orders_.components_of(entries);
  const ConstArrayView values(x);
  vectors_.push_back({path, &order, components, order.rows(values.span(), components)});
}

void CheckpointWriter::write(const std::filesystem::path& file, const CheckpointInfo& info) const {
  std::filesystem::path part = file;
  part += ".part";
  Group group{"/", "state", {}, {}};
  group.write_attributes = [&](hid_t state) {
    for (const auto& [path, values] : numbers_) write_attribute(state, path, values);
  };
  for (const auto& [path, order, components, rows] : vectors_) {
    group.datasets.push_back({path,
                              XdmfArray::Number::float64,
                              {order->first_row(), order->num_rows(), order->num_global()},
                              components,
                              std::as_bytes(std::span(rows)),
                              {}});
  }
  try {
    on_root(comm_, [&] { start_file(part, info); });
    add_group(comm_, part, group, Durability::power);
    std::int64_t size = 0;
    on_root(comm_, [&] { size = size_of(part); });
    check_mpi(MPI_Bcast(&size, 1, MPI_INT64_T, 0, comm_));
    const unsigned long checksum = checksum_of(comm_, part, size);
    on_root(comm_, [&] {
      const std::string text = header(size, checksum);
      File out(part, FileMode::modify);
      out.write_at(0, std::as_bytes(std::span(text)));
      out.sync();
      out.close();
      replace_file(part, file);
    });
  } catch (const FileError&) {
    std::error_code ignored;
    if (rank(comm_) == 0) std::filesystem::remove(part, ignored);
    throw;
  }
}

CheckpointReader::CheckpointReader(MPI_Comm comm, std::filesystem::path file, const ArchiveOrders& orders)
    : comm_(comm), file_(std::move(file)), orders_(orders) {
  on_every_rank(comm, [&] {
    const QuietHdf5 quiet;
    const Hdf5Handle opened = open_hdf5(file_, Hdf5Mode::read);
    state_ = Hdf5Handle(H5Gopen2(opened.get(), "state", H5P_DEFAULT), H5Gclose, "read '" + file_.string() + "'");
  });
}

void CheckpointReader::exchange(const std::string& path, std::span<double> x) {
  on_every_rank(comm_, [&] {
    const QuietHdf5 quiet;
    read_attribute(state_.get(), path, x);
  });
}

void CheckpointReader::exchange(const std::string& path, Entries entries, Vec x) {
  const GlobalOrder& order = orders_.of(entries);
  const int components = orders_.components_of(entries);
  std::vector<double> rows(static_cast<std::size_t>(components * order.num_rows()));
  on_every_rank(comm_, [&] {
    const QuietHdf5 quiet;
    const std::string doing = fmt::format("read '{}' of '{}'", path, file_.string());
    const Hdf5Handle dataset(H5Dopen2(state_.get(), path.c_str(), H5P_DEFAULT), H5Dclose, doing);
    const auto sizes = sizes_of(dataset.get());
    std::vector<hsize_t> wanted{static_cast<hsize_t>(order.num_global())};
    if (sizes.size() > 1 || components > 1) wanted.push_back(static_cast<hsize_t>(components));
    if (sizes != wanted) {
      throw FileError(fmt::format("cannot {}: its number of entries does not match the mesh", doing));
    }
    read_rows(dataset.get(), {order.first_row(), order.num_rows()}, H5T_NATIVE_DOUBLE, rows.data());
  });
  const auto values = order.entries(rows, components);
  const ArrayView into(x);
  std::ranges::copy(values, into.span().begin());
}

bool is_checkpoint(const std::filesystem::path& file) {
  return start_of(file).starts_with(magic);
}

CheckpointInfo read_checkpoint_info(MPI_Comm comm, const std::filesystem::path& file) {
  std::int64_t size = 0;
  std::string found;
  on_root(comm, [&] {
    size = size_of(file);
    found = start_of(file);
    if (!found.starts_with(magic)) throw unreadable(file, "it is not a checkpoint of Pliant");
    const std::string start = fmt::format("{}\nversion {}\nbytes ", magic, version);
    if (!found.starts_with(start)) {
      throw unreadable(file, fmt::format("it was written by another version of Pliant, or its beginning is damaged; "
                                         "this one reads version {} of the format",
                                         version));
    }
    const std::string bytes = found.substr(start.size(), found.find('\n', start.size()) - start.size());
    if (bytes != std::to_string(size) || size < header_size) {
      throw unreadable(file, fmt::format("it is damaged: it has {} bytes and should have {}", size, bytes));
    }
  });
  check_mpi(MPI_Bcast(&size, 1, MPI_INT64_T, 0, comm));
  const unsigned long checksum = checksum_of(comm, file, size);
  CheckpointInfo info;
  on_root(comm, [&] {
    if (found != header(size, checksum)) throw unreadable(file, "it is damaged: its checksum is wrong");
  });
  on_every_rank(comm, [&] {
    const QuietHdf5 quiet;
    const Hdf5Handle opened = open_hdf5(file, Hdf5Mode::read);
    info.step = integer_attribute(opened.get(), "step");
    info.time = finite_attribute(opened.get(), "time");
    info.ranks = integer_attribute(opened.get(), "ranks");
    for (const auto& [name, text] : {std::pair{"title", &info.title},
                                     {"mesh", &info.mesh},
                                     {"program", &info.program},
                                     {"petsc_options", &info.petsc_options}}) {
      *text = text_attribute(opened.get(), name);
    }
    info.input = read_text(opened.get(), "input");
  });
  return info;
}

}  // namespace pliant
