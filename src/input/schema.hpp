/// The parts from which the table of the input's keys is made (the table itself: input/keys.cpp and input/sections). A
/// Format says how one kind of value is typed (input/formats.hpp has those of single values); a Field ties a key and a
/// format to a member; a Section is the keys of one map. Reading, defaults, writing, the JSON schema and the reference
/// all follow from them.
#pragma once

#include "input/config.hpp"
#include "input/parse.hpp"
#include "input/tree.hpp"

#include <array>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace pliant {

/// JSON schema of a value. Shared and never changed; opaque here, since the library of JSON takes long to compile.
using JsonSchema = std::shared_ptr<const nlohmann::ordered_json>;

/// A key, or a value of a choice, to which other keys of the section belong.
struct Anchor {
  std::string key;
  std::string value = {};  ///< empty: any
};

/// "key" or "key: value".
std::string to_string(const Anchor& anchor);

/// Keys of a section, and how many of them must be given.
struct KeyGroup {
  enum class Need { exactly_one, at_least_one, at_most_one, all, any };
  std::vector<std::string> keys;
  Need need = Need::exactly_one;
  std::vector<Anchor> only_with = {};  ///< if given, the keys belong to these and are allowed only with one of them
  std::vector<std::vector<std::string>> together = {};  ///< exactly_one: sets of keys that count as one
};

/// A list that copies share.
template <class T>
class SharedList {
 public:
  SharedList() = default;
  SharedList(std::vector<T> items) : items_(std::make_shared<const std::vector<T>>(std::move(items))) {}

  const std::vector<T>& all() const {
    static const std::vector<T> none;
    return items_ ? *items_ : none;
  }
  operator const std::vector<T>&() const { return all(); }
  auto begin() const { return all().begin(); }
  auto end() const { return all().end(); }
  bool empty() const { return all().empty(); }
  const T& front() const { return all().front(); }

 private:
  std::shared_ptr<const std::vector<T>> items_;
};

/// A function whose copies share what it holds.
template <class Signature>
class SharedFunction;
template <class Result, class... Argument>
class SharedFunction<Result(Argument...)> {
 public:
  SharedFunction() = default;
  template <class F>
  requires(!std::is_same_v<std::remove_cvref_t<F>, SharedFunction>) SharedFunction(F&& function)
      : function_(std::make_shared<const std::function<Result(Argument...)>>(std::forward<F>(function))) {}

  Result operator()(Argument... arguments) const {
    if (!function_) throw std::bad_function_call();
    return (*function_)(std::forward<Argument>(arguments)...);
  }

 private:
  std::shared_ptr<const std::function<Result(Argument...)>> function_;
};

/// A key as users see it. Keys contain keys, four levels deep: copies share their lists, because copying all levels
/// took longer than reading an input.
struct KeyInfo {
  enum class Need { optional, required };
  std::string key;
  std::string type;  ///< in words
  std::string description;
  Need need = Need::optional;
  std::string fallback = {};           ///< the default as a user would type it; empty: none
  std::string fallback_words = {};     ///< a default that depends on other keys, in words
  JsonSchema schema = {};              ///< of the value
  SharedList<KeyInfo> children = {};   ///< the keys of a section or of the entries of a list of sections
  SharedList<KeyGroup> groups = {};    ///< of the children
  std::vector<std::string> also = {};  ///< other names for it, for which this key is suggested
  std::vector<Anchor> only_with = {};  ///< choices with which the key is useful, and suggested; empty: all

  /// Is the value of this JSON type?
  bool has_type(const char* json_type) const;
};

/// How a value of type V is typed. `read` stores the value and returns whether it could; it reports errors to the
/// diagnostics, under the name given. `write` is its inverse; a null node means: leave the key out.
template <class V>
struct Format {
  std::string type;
  JsonSchema schema;
  SharedFunction<bool(const InputNode&, const std::string& name, Diagnostics&, V&)> read;
  SharedFunction<InputNode(const V&)> write;
  SharedList<KeyInfo> children = {};
  SharedList<KeyGroup> groups = {};
};

/// A hint for a message where a ',' within a number or a formula has split an entry of the list; else empty.
std::string why_split(const InputNode& list);
/// Warns of lists in [ ] that may have a decimal comma: one ',' is followed directly by digits, another by a blank, as
/// in [0,45, 0].
void warn_of_decimal_commas(const InputNode& node, Diagnostics& diagnostics);
/// Whether the text is the beginning or end of a formula, which a ',' has split.
bool is_part_of_formula(std::string_view text);

/// Adds "'name' must be ..., not ..." at the node. Returns false, so that a reader can return the result.
bool refuse(const InputNode& node, const std::string& name, const std::string& wanted, Diagnostics& diagnostics);

/// The same for a list of fewer entries than these.
bool refuse_short(const InputNode& list, const std::string& name, std::size_t fewest, Diagnostics& diagnostics);

/// Reports keys of a map that are unknown, missing or in conflict. Returns whether the node is a map at all.
bool check_keys(const InputNode& node, const std::string& name, const KeyInfo& section, Diagnostics& diagnostics);

/// JSON schema of a list; without `most` it has no upper limit.
JsonSchema list_schema(const JsonSchema& entry, std::size_t fewest, std::optional<std::size_t> most = {});
/// JSON schema of a value that can be typed in two ways.
JsonSchema either_schema(const JsonSchema& one, const JsonSchema& other);
/// JSON schema of a map with these keys.
JsonSchema object_schema(const std::vector<KeyInfo>& keys, const std::vector<KeyGroup>& groups);

/// A list of exactly N values.
template <std::size_t N, class V>
Format<std::array<V, N>> array_of(const Format<V>& component) {
  const std::string type = "list of " + std::to_string(N) + ", each " + component.type;
  Format<std::array<V, N>> format{type, list_schema(component.schema, N, N), {}, {}};
  format.read = [component](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                            std::array<V, N>& into) {
    const std::string wanted = "a list of " + std::to_string(N) + " values";
    if (node.kind != InputNode::Kind::list) return refuse(node, name, wanted, diagnostics);
    if (node.children.size() != N) {
      diagnostics.add(node.where, "'" + name + "' must be " + wanted + ", not of " +
                                      std::to_string(node.children.size()) + why_split(node));
      return false;
    }
    bool good = true;
    for (std::size_t i = 0; i < N; ++i) {
      const std::string item_name = name + "[" + std::to_string(i) + "]";
      good = component.read(node.children[i], item_name, diagnostics, into[i]) && good;
    }
    return good;
  };
  format.write = [component](const std::array<V, N>& values) {
    std::vector<InputNode> items;
    for (const V& value : values) items.push_back(component.write(value));
    return InputNode::list(std::move(items));
  };
  return format;
}

/// A list of at least `fewest` entries.
template <class V>
Format<std::vector<V>> list_of(const Format<V>& entry, std::size_t fewest) {
  Format<std::vector<V>> format{
      "list, each " + entry.type, list_schema(entry.schema, fewest), {}, {}, entry.children, entry.groups};
  format.read = [entry, fewest](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                std::vector<V>& into) {
    if (node.kind != InputNode::Kind::list) {
      return refuse(node, name, "a list (each entry starts with '- ')", diagnostics);
    }
    if (node.children.size() < fewest) return refuse_short(node, name, fewest, diagnostics);
    for (std::size_t i = 0; i < node.children.size(); ++i) {
      into.emplace_back();
      entry.read(node.children[i], name + "[" + std::to_string(i) + "]", diagnostics, into.back());
    }
    return true;
  };
  format.write = [entry](const std::vector<V>& values) {
    if (values.empty()) return InputNode{};
    std::vector<InputNode> items;
    for (const V& value : values) items.push_back(entry.write(value));
    return InputNode::list(std::move(items));
  };
  return format;
}

/// An entry, or a list of at least one.
template <class V>
Format<std::vector<V>> one_or_list_of(const Format<V>& entry) {
  const auto several = list_of(entry, 1);
  Format<std::vector<V>> format = several;
  format.type = entry.type + ", or a list of such";
  format.schema = either_schema(entry.schema, several.schema);
  format.read = [entry, several](const InputNode& node, const std::string& name, Diagnostics& diagnostics,
                                 std::vector<V>& into) {
    if (node.kind == InputNode::Kind::list) return several.read(node, name, diagnostics, into);
    return entry.read(node, name, diagnostics, into.emplace_back());
  };
  format.write = [entry, several](const std::vector<V>& values) {
    return values.size() == 1 ? entry.write(values.front()) : several.write(values);
  };
  return format;
}

/// Where a field keeps its value: as it is, only if given, or with its place.
template <class V>
void store(V value, const Location&, V& member) {
  member = std::move(value);
}
template <class V>
void store(V value, const Location&, std::optional<V>& member) {
  member = std::move(value);
}
template <class V>
void store(V value, const Location& where, Located<V>& member) {
  member = {std::move(value), where};
}
template <class M>
constexpr bool is_optional = false;
template <class V>
constexpr bool is_optional<std::optional<V>> = true;

/// The stored value, if there is one. V must be given explicitly, because it may itself be an optional.
template <class V>
const V* stored(const V& member) {
  return &member;
}
template <class V>
const V* stored(const std::optional<V>& member) {
  return member ? &*member : nullptr;
}
template <class V>
const V* stored(const Located<V>& member) {
  return &member.value;
}

/// A key of the section that is read into T.
template <class T>
struct Field {
  KeyInfo info;
  std::optional<InputNode> fallback = {};  ///< read where the key is not given
  SharedFunction<void(const InputNode&, Diagnostics&, T&)> read = {};
  SharedFunction<InputNode(const T&)> write = {};
  std::vector<Anchor> owners = {};  ///< if given, the key is allowed only with one of these

  Field required() && {
    info.need = KeyInfo::Need::required;
    fallback.reset();
    return std::move(*this);
  }
  /// The default, as a user would type it.
  Field otherwise(const std::string& yaml) && {
    Diagnostics none;
    info.fallback = yaml;
    fallback = parse_yaml(yaml, "default", none);
    return std::move(*this);
  }
  /// A default that depends on other keys and is set after reading.
  Field otherwise_in_words(std::string words) && {
    info.fallback_words = std::move(words);
    return std::move(*this);
  }
  /// A section that may be missing as a whole: its required keys are required where it is given.
  Field or_none(std::string words) && {
    info.fallback_words = std::move(words);
    fallback.reset();
    return std::move(*this);
  }
  /// The key belongs to these: it is allowed only with one of them, and required there unless it has a default.
  Field only_with(std::vector<Anchor> anchors) && {
    owners = std::move(anchors);
    return std::move(*this);
  }
  /// The key is left out when writing where this holds.
  Field left_out_if(std::function<bool(const T&)> condition) && {
    write = [condition = std::move(condition), full = std::move(write)](const T& from) {
      return condition(from) ? InputNode{} : full(from);
    };
    return std::move(*this);
  }
};

template <class V>
KeyInfo info_of(const std::string& key, const Format<V>& format, const std::string& description) {
  KeyInfo info{key, format.type, description};
  info.schema = format.schema;
  info.children = format.children;
  info.groups = format.groups;
  return info;
}

template <class T, class M, class V>
Field<T> field(const std::string& key, M T::*member, const Format<V>& format, const std::string& description) {
  Field<T> result{info_of(key, format, description)};
  if (result.info.has_type("object") && !is_optional<M>) result.fallback = InputNode::map({});  // its keys' defaults
  result.read = [key, member, read = format.read](const InputNode& node, Diagnostics& diagnostics, T& into) {
    V value{};
    if (read(node, key, diagnostics, value)) store(std::move(value), node.where, into.*member);
  };
  result.write = [member, write = format.write](const T& from) {
    const V* value = stored<V>(from.*member);
    return value == nullptr ? InputNode{} : write(*value);
  };
  return result;
}

/// The keys of a map that is read into T, in the order in which they are read.
template <class T>
struct Section {
  std::vector<Field<T>> fields;
  std::vector<KeyGroup> groups = {};  ///< in addition to those of fields with owners
  Location T::*where = nullptr;       ///< where T keeps the map's place

  void read(const InputNode& node, Diagnostics& diagnostics, T& into) const {
    if (where != nullptr) into.*where = node.where;
    for (const Field<T>& f : fields) {
      const InputNode* given = node.find(f.info.key);
      if (given != nullptr && given->kind != InputNode::Kind::null) {
        const std::size_t num_errors = diagnostics.num_errors();
        f.read(*given, diagnostics, into);
        if (diagnostics.num_errors() > num_errors) diagnostics.note_wrong(node.where, f.info.key);
      } else if (f.fallback) {
        InputNode fallback = *f.fallback;
        fallback.where = node.where;
        f.read(fallback, diagnostics, into);
      }
    }
  }
  std::vector<KeyGroup> all_groups() const {
    std::vector<KeyGroup> all = groups;
    for (const Field<T>& f : fields) {
      if (f.owners.empty()) continue;
      const bool has_default = f.fallback || !f.info.fallback_words.empty();
      all.push_back({{f.info.key}, has_default ? KeyGroup::Need::any : KeyGroup::Need::all, f.owners});
    }
    return all;
  }
  InputNode write(const T& from) const {
    std::vector<InputNode> entries;
    for (const Field<T>& f : fields) {
      InputNode value = f.write(from);
      if (value.kind != InputNode::Kind::null) entries.push_back(std::move(value).under(f.info.key));
    }
    return InputNode::map(std::move(entries));
  }
};

/// A map with the keys of the section; an empty name is the whole input.
template <class T>
Format<T> map_of(const Section<T>& section) {
  Format<T> format{"with the keys below", {}, {}, {}};
  std::vector<KeyInfo> keys;
  for (const Field<T>& f : section.fields) keys.push_back(f.info);
  format.children = std::move(keys);
  format.groups = section.all_groups();
  format.schema = object_schema(format.children, format.groups);
  KeyInfo info;
  info.children = format.children;
  info.groups = format.groups;
  format.read = [section, info](const InputNode& node, const std::string& name, Diagnostics& diagnostics, T& into) {
    if (check_keys(node, name, info, diagnostics)) section.read(node, diagnostics, into);
    return true;  // the checks that follow use what could be read
  };
  format.write = [section](const T& from) { return section.write(from); };
  return format;
}

}  // namespace pliant
