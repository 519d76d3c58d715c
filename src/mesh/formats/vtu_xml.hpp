/// As much of XML as VTK's files need.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

struct XmlElement {
  std::string name;
  std::map<std::string, std::string> attributes;
  std::vector<std::size_t> children;  ///< indices in XmlDocument::elements
  std::string_view text;              ///< between its tags, if it has no children
  std::size_t line = 0;

  std::string attribute(const std::string& key) const;  ///< empty if there is none
};

struct XmlDocument {
  std::vector<XmlElement> elements;  ///< the root first
  std::string_view appended;         ///< what follows <AppendedData> and its '_', to the end of the file

  /// The children of that name.
  std::vector<const XmlElement*> children(const XmlElement& parent, std::string_view name) const;
};

/// Parses the file up to <AppendedData>, whose contents may be binary. Views point into `bytes`. Throws MeshDefect with
/// the line where it is malformed or incomplete.
XmlDocument parse_xml(std::string_view bytes);

}  // namespace pliant
