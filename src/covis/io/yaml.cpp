// SPDX-License-Identifier: Apache-2.0
#include "covis/io/yaml.h"

#include <yaml-cpp/depthguard.h>
#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "covis/io/files.h"

namespace covis::io {
namespace {

constexpr size_t kMostNumbers = 1000;  // a list's: aliases make long lists of short files

// Takes where a document begins, and nothing else of it.
class Beginning : public YAML::EventHandler {
 public:
  const std::optional<YAML::Mark>& mark() const { return mark_; }
  bool is_empty() const { return is_empty_; }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { take(mark, true); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t, const std::string&) override { take(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { take(mark); }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    take(mark);
  }
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    take(mark);
  }
  void OnMapEnd() override {}

 private:
  void take(const YAML::Mark& mark, bool is_empty = false) {
    if (mark_) return;
    mark_ = mark;
    is_empty_ = is_empty;
  }

  std::optional<YAML::Mark> mark_;
  bool is_empty_ = false;
};

class SecondDocument : public YAML::Exception {
 public:
  using YAML::Exception::Exception;
};

// The only document of the text, but for empty ones. YAML::LoadAll would never end where no value can begin (","
// alone): yaml-cpp makes an empty document of that, stays where it is, and makes another.
YAML::Node only_document(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  std::optional<YAML::Mark> before;
  while (true) {
    Beginning document;
    if (!parser.HandleNextDocument(document) || !document.mark()) return YAML::Load(text);
    const YAML::Mark mark = *document.mark();
    if (before && before->pos == mark.pos) throw YAML::ParserException(mark, "no value begins like this");
    if (before && !document.is_empty())
      throw SecondDocument(mark, "a second document begins here (after ---); one is expected");
    before = mark;
  }
}

// Looks for what a YAML::Node is silent about: a key that a map has twice, whose first value would count; and an alias
// within the node that it stands for, as the node would be endless.
class Flaws : public YAML::EventHandler {
 public:
  // Returns what is wrong first and where; nothing is: an empty text.
  const std::string& problem() const { return problem_; }
  const YAML::Mark& place() const { return place_; }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override { step(); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t, const std::string& value) override {
    if (step() && !open_.back().keys.insert(value).second) say(mark, "'" + value + "' is given twice");
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    step();
    if (std::any_of(open_.begin(), open_.end(), [&](const Open& node) { return node.anchor == anchor; }))
      say(mark, "not YAML that can be read: what an alias (*) stands for contains the alias itself");
  }
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    step();
    open_.push_back({anchor, false, false, {}});
  }
  void OnSequenceEnd() override { open_.pop_back(); }
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t anchor, YAML::EmitterStyle::value) override {
    step();
    open_.push_back({anchor, true, false, {}});
  }
  void OnMapEnd() override { open_.pop_back(); }

 private:
  // A list or map around the present place.
  struct Open {
    YAML::anchor_t anchor = 0;
    bool is_map = false, value_is_next = false;
    std::set<std::string> keys;
  };

  // Returns whether what begins here is a key of a map.
  bool step() {
    if (open_.empty() || !open_.back().is_map) return false;
    return std::exchange(open_.back().value_is_next, !open_.back().value_is_next) == false;
  }
  void say(const YAML::Mark& mark, std::string problem) {
    if (!problem_.empty()) return;
    problem_ = std::move(problem);
    place_ = mark;
  }

  std::vector<Open> open_;
  std::string problem_;
  YAML::Mark place_;
};

// yaml-cpp reads UTF-16 and UTF-32 too, where the files begin with a mark.
bool is_text(std::string_view text) {
  using namespace std::literals;
  const bool wide = text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff") || text.starts_with("\0\0\xfe\xff"sv);
  return wide || text.find('\0') == std::string_view::npos;
}

// Returns parse(text), which may throw what yaml-cpp throws.
template <class Parse>
auto parsed(const std::filesystem::path& file, Parse parse) -> Result<decltype(parse(std::string()))> {
  std::string text;
  if (auto read = read_bytes(file, text); !read) return tl::unexpected(read.error());
  if (!is_text(text)) return fail(file.string() + ": not YAML: it is no text");
  remove_byte_order_mark(text);
  // OpenCV and EuRoC write "%YAML:1.0", which is not a valid YAML directive.
  if (text.starts_with("%YAML:")) text.replace(0, 1, "#");
  const auto place = [&](int line) { return file.string() + ":" + std::to_string(line); };
  try {
    Flaws flaws;
    std::istringstream stream(text);
    YAML::Parser(stream).HandleNextDocument(flaws);
    if (!flaws.problem().empty()) return fail(place(flaws.place().line + 1) + ": " + flaws.problem());
    return parse(text);
  } catch (const YAML::DeepRecursion& error) {
    return fail(place(error.mark.line + 1) + ": not YAML that can be read: it is nested too deep");
  } catch (const SecondDocument& error) {
    return fail(place(error.mark.line + 1) + ": " + error.msg);
  } catch (const YAML::Exception& error) {
    return fail(place(error.mark.line + 1) + ": not YAML: " + error.msg);
  }
}

// Appends the numbers of a list and of the lists in it.
Result<void> append_numbers(const std::filesystem::path& file, const YAML::Node& list, const char* key,
                            std::vector<double>& values) {
  for (const auto& item : list) {
    if (item.IsSequence()) {
      if (auto appended = append_numbers(file, item, key, values); !appended) return appended;
      continue;
    }
    const std::string text = item.IsScalar() ? item.Scalar() : "a map";
    const auto value = parse_double(text);
    if (!value) return fail(yaml_place(file, item) + ": " + key + ": '" + text + "' is not a finite number");
    if (values.size() == kMostNumbers)
      return fail(yaml_place(file, list) + ": " + key + " has more than " + std::to_string(kMostNumbers) + " numbers");
    values.push_back(*value);
  }
  return {};
}

}  // namespace

Result<YAML::Node> load_yaml(const std::filesystem::path& file) {
  return parsed(file, [](const std::string& text) { return YAML::Load(text); });
}

Result<YAML::Node> load_only_yaml(const std::filesystem::path& file) { return parsed(file, only_document); }

std::string yaml_place(const std::filesystem::path& file, const YAML::Node& node) {
  return file.string() + ":" + std::to_string(node.Mark().line + 1);
}

Result<std::vector<double>> yaml_numbers(const std::filesystem::path& file, const YAML::Node& parent, const char* key,
                                         size_t least) {
  YAML::Node node;
  if (parent.IsMap() && parent[key]) node = parent[key];
  if (node.IsMap() && node["data"]) node.reset(node["data"]);
  if (!node.IsSequence()) return fail(file.string() + ": '" + key + "' is missing, a list of numbers is expected");
  std::vector<double> values;
  if (auto appended = append_numbers(file, node, key, values); !appended) return tl::unexpected(appended.error());
  if (values.size() < least)
    return fail(yaml_place(file, node) + ": " + key + " needs " + std::to_string(least) + " numbers");
  return values;
}

Result<double> yaml_number(const std::filesystem::path& file, const YAML::Node& parent, const char* key) {
  const std::string text = yaml_text(parent, key, "");
  if (text.empty()) return fail(file.string() + ": '" + key + "' is missing, a number is expected");
  const auto value = parse_double(text);
  if (!value) return fail(yaml_place(file, parent[key]) + ": " + key + ": '" + text + "' is not a finite number");
  return *value;
}

std::string yaml_text(const YAML::Node& parent, const char* key, const std::string& otherwise) {
  if (!parent.IsMap() || !parent[key] || !parent[key].IsScalar()) return otherwise;
  return parent[key].Scalar();
}

}  // namespace covis::io
