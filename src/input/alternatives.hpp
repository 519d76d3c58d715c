/// Keys of a section that holds one of several alternatives, a std::variant of small structs. Either a key names the
/// alternative (`shape: sphere`), or the presence of a key implies it (`traction: ...`). Each alternative has members
/// of its own, which are read and written only where it is the one chosen.
#pragma once

#include "input/formats.hpp"

#include <array>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace pliant {

/// A key of a part of T, as a key of T.
template <class T, class Part>
Field<T> within(Part T::*part, const Field<Part>& of_part) {
  Field<T> result{of_part.info, of_part.fallback, {}, {}, of_part.owners};
  result.read = [part, read = of_part.read](const InputNode& node, Diagnostics& diagnostics, T& into) {
    read(node, diagnostics, into.*part);
  };
  result.write = [part, write = of_part.write](const T& from) { return write(from.*part); };
  return result;
}

/// A key of one or several alternatives, which stores its value in the member of the one that is chosen.
template <class T, class... All, class V, class... Alternative, class... Member>
Field<T> field_of(std::variant<All...> T::*choice, const std::string& key, const Format<V>& format,
                  const std::string& description, Member Alternative::*... members) {
  Field<T> result{info_of(key, format, description)};
  result.read = [=, read = format.read](const InputNode& node, Diagnostics& diagnostics, T& into) {
    V value{};
    if (!read(node, key, diagnostics, value)) return;
    const auto keep = [&]<class A, class M>(M A::*member) {
      if (A* chosen = std::get_if<A>(&(into.*choice))) store(value, node.where, chosen->*member);
    };
    (keep(members), ...);
  };
  result.write = [=, write = format.write](const T& from) {
    const V* value = nullptr;
    const auto find = [&]<class A, class M>(M A::*member) {
      if (const A* chosen = std::get_if<A>(&(from.*choice))) value = stored<V>(chosen->*member);
    };
    (find(members), ...);
    return value == nullptr ? InputNode{} : write(*value);
  };
  return result;
}

/// A key whose presence chooses the alternative that has the member.
template <class T, class... All, class V, class A, class M>
Field<T> choosing_field(std::variant<All...> T::*choice, const std::string& key, const Format<V>& format,
                        const std::string& description, M A::*member) {
  Field<T> result = field_of(choice, key, format, description, member);
  result.read = [choice, read = result.read](const InputNode& node, Diagnostics& diagnostics, T& into) {
    if (!std::holds_alternative<A>(into.*choice)) into.*choice = A{};
    read(node, diagnostics, into);
  };
  return result;
}

/// A key whose value is the alternative.
template <class T, class... All, class A>
Field<T> choosing_field(std::variant<All...> T::*choice, const std::string& key, const Format<A>& format,
                        const std::string& description) {
  Field<T> result{info_of(key, format, description)};
  result.read = [=, read = format.read](const InputNode& node, Diagnostics& diagnostics, T& into) {
    A value{};
    read(node, key, diagnostics, value);
    into.*choice = std::move(value);
  };
  result.write = [choice, write = format.write](const T& from) {
    const A* chosen = std::get_if<A>(&(from.*choice));
    return chosen == nullptr ? InputNode{} : write(*chosen);
  };
  return result;
}

/// A variant of T whose alternatives have names, one of which is the value of a key.
template <class T, class... All>
class NamedAlternatives {
 public:
  using Choice = std::variant<All...>;
  using Names = std::array<std::string, sizeof...(All)>;  ///< in the order of the alternatives

  NamedAlternatives(std::string key, Choice T::*member, Names names)
      : key_(std::move(key)), member_(member), names_(std::move(names)) {}

  /// The key that names the alternative; the fields below come after it in the section.
  Field<T> choice(const std::string& description) const {
    const Format<std::string> by_name = pliant::choice({names_.begin(), names_.end()});
    Field<T> result{info_of(key_, by_name, description)};
    result.read = [key = key_, member = member_, names = names_, read = by_name.read](
                      const InputNode& node, Diagnostics& diagnostics, T& into) {
      static const std::array<Choice, sizeof...(All)> blanks{Choice(All{})...};
      std::string name;
      if (!read(node, key, diagnostics, name)) return;
      for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == name) into.*member = blanks[i];
      }
    };
    result.write = [member = member_, names = names_, write = by_name.write](const T& from) {
      return write(names[(from.*member).index()]);
    };
    return result;
  }

  /// A key of the alternatives that have the members.
  template <class V, class... Alternative, class... Member>
  Field<T> field(const std::string& key, const Format<V>& format, const std::string& description,
                 Member Alternative::*... members) const {
    std::vector<Anchor> anchors;
    constexpr std::array<bool, sizeof...(All)> has_key{is_one_of<All, Alternative...>...};
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (has_key[i]) anchors.push_back({key_, names_[i]});
    }
    return field_of(member_, key, format, description, members...).only_with(std::move(anchors));
  }

 private:
  template <class A, class... Some>
  static constexpr bool is_one_of = (std::is_same_v<A, Some> || ...);

  std::string key_;
  Choice T::*member_;
  Names names_;
};

}  // namespace pliant
