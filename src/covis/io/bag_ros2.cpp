// SPDX-License-Identifier: Apache-2.0
// ROS 2 bags in SQLite's storage: the tables topics (id, name, type, serialization_format) and messages (id, topic_id,
// timestamp, data).
#include <sqlite3.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <mutex>
#include <utility>

#include "covis/io/bag.h"
#include "covis/io/files.h"

namespace covis::io {
namespace {

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
};
struct CloseStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
struct CloseBlob {
  void operator()(sqlite3_blob* blob) const { sqlite3_blob_close(blob); }
};

// "sensor_msgs/Image" of "sensor_msgs/msg/Image".
std::string type_of_ros1(const std::string& type) {
  const size_t at = type.find("/msg/");
  return at == std::string::npos ? type : type.substr(0, at) + type.substr(at + 4);
}

std::string text_at(sqlite3_stmt* row, int column) {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
  return text ? std::string(text, static_cast<size_t>(sqlite3_column_bytes(row, column))) : std::string();
}

// For SQLite, which would take '?', '#' and '%' of a name for more than that. file: an absolute path.
std::string immutable_uri(const std::filesystem::path& file) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string uri = "file://";
  for (const char c : file.string()) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) || c == '/') {
      uri += c;
    } else {
      uri += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
    }
  }
  return uri + "?immutable=1";
}

// One database.
class BagFile {
 public:
  explicit BagFile(std::filesystem::path file) : file_(std::move(file)) {}

  Result<void> open() {
    std::error_code error;
    const std::filesystem::path real = std::filesystem::canonical(file_, error);  // a recorder's files are beside it
    if (error) return fail(file_.string() + ": " + error.message());
    if (auto written = is_written(real); !written) return written;
    size_ = static_cast<int64_t>(std::filesystem::file_size(file_));
    sqlite3* opened = nullptr;
    // Immutable: no file beside the bag is read or made.
    const int code =
        sqlite3_open_v2(immutable_uri(real).c_str(), &opened, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
    database_.reset(opened);
    if (code != SQLITE_OK) return damaged(message());
    // SQLite advises this for files of strangers; nothing but rows of tables is wanted of it.
    sqlite3_drop_modules(opened, nullptr);
    sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, static_cast<int>(std::min<int64_t>(size_, 1'000'000'000)));
    if (auto whole = is_whole(); !whole) return whole;
    return has_plain_tables();
  }

  // Calls visit(row) for each row of the answer until it returns an error.
  template <class Visit>
  Result<void> select(const char* query, Visit&& visit) {
    // A row takes more bytes than instructions of SQLite to read it. A damaged file may seem to have any number of
    // them.
    constexpr int kStep = 1000;
    int64_t steps_left = 10'000 + size_ / kStep;
    const auto spent = [](void* left) { return static_cast<int>(--*static_cast<int64_t*>(left) < 0); };
    sqlite3_progress_handler(database_.get(), kStep, spent, &steps_left);
    const Result<void> visited = visit_rows(query, visit);
    sqlite3_progress_handler(database_.get(), 0, nullptr, nullptr);
    return steps_left < 0 ? damaged("it has more rows than a file of its size can hold") : visited;
  }

  Result<void> read(int64_t row, std::string& bytes, size_t most) {
    bool found = blob_ && sqlite3_blob_reopen(blob_.get(), row) == SQLITE_OK;
    if (!found) {
      sqlite3_blob* opened = nullptr;
      found = sqlite3_blob_open(database_.get(), "main", "messages", "data", row, 0, &opened) == SQLITE_OK;
      blob_.reset(opened);
    }
    if (!found) return damaged(message());
    if (sqlite3_blob_bytes(blob_.get()) > size_) return damaged("a message is longer than the file");
    bytes.resize(std::min(most, static_cast<size_t>(sqlite3_blob_bytes(blob_.get()))));
    if (sqlite3_blob_read(blob_.get(), bytes.data(), static_cast<int>(bytes.size()), 0) != SQLITE_OK)
      return damaged(message());
    return {};
  }

  const std::filesystem::path& file() const { return file_; }

 private:
  // Error: a recorder that did not end well left changes beside the file, to put into it or to undo.
  static Result<void> is_written(const std::filesystem::path& real) {
    const std::string sqlite = "`sqlite3 '" + real.string() + "' ";
    const std::pair<const char*, std::string> files[] = {
        {"-wal",
         "it holds changes that are not in the bag yet; " + sqlite + "'PRAGMA journal_mode=DELETE'` puts them there"},
        {"-journal", "an unfinished change of the bag must be undone first; " + sqlite + ".tables` does that"}};
    for (const auto& [suffix, problem] : files) {
      const std::filesystem::path beside = real.string() + suffix;
      std::error_code none;
      if (!std::filesystem::exists(beside, none)) continue;
      const auto head = read_head(beside, 1);
      if (!head) return tl::unexpected(head.error());
      if (head->empty() || head->front() == '\0') continue;  // it holds no entry that counts
      return fail(beside.string() + ": " + problem);
    }
    return {};
  }

  template <class Visit>
  Result<void> visit_rows(const char* query, Visit&& visit) {
    sqlite3_stmt* prepared = nullptr;
    if (sqlite3_prepare_v2(database_.get(), query, -1, &prepared, nullptr) != SQLITE_OK) return damaged(message());
    const std::unique_ptr<sqlite3_stmt, CloseStatement> statement(prepared);
    int code = SQLITE_ROW;
    while ((code = sqlite3_step(prepared)) == SQLITE_ROW) {
      if (Result<void> visited = visit(prepared); !visited) return visited;
    }
    if (code != SQLITE_DONE) return damaged(message());
    return {};
  }

  // SQLite sees that pages are missing, but not that the last one is cut.
  Result<void> is_whole() {
    int64_t bytes = 0;
    auto asked = select("SELECT page_count * page_size FROM pragma_page_count(), pragma_page_size()",
                        [&](sqlite3_stmt* row) -> Result<void> {
                          bytes = sqlite3_column_int64(row, 0);
                          return {};
                        });
    if (asked && size_ < bytes)
      return damaged(std::to_string(bytes) + " bytes are announced, " + std::to_string(size_) + " are there");
    return asked;
  }

  // A view, a virtual table or a computed column could be anything.
  Result<void> has_plain_tables() {
    return select(
        "SELECT name FROM pragma_table_list AS t WHERE schema = 'main' AND lower(name) IN ('topics', 'messages') AND "
        "(type <> 'table' OR EXISTS (SELECT 1 FROM pragma_table_xinfo(t.name) WHERE hidden <> 0))",
        [&](sqlite3_stmt* row) -> Result<void> {
          return fail(file_.string() + ": '" + text_at(row, 0) +
                      "' is no plain table; a bag of ROS 2 has the tables topics and messages");
        });
  }

  std::string message() const { return database_ ? sqlite3_errmsg(database_.get()) : "there is no memory"; }
  tl::unexpected<Error> damaged(const std::string& problem) const {
    return fail(file_.string() + ": the bag can't be read: " + problem + ". If it was cut short, `sqlite3 " +
                file_.filename().string() + " .recover | sqlite3 whole.db3` makes what is there readable");
  }

  std::filesystem::path file_;
  int64_t size_ = 0;  // the file's, bytes
  std::unique_ptr<sqlite3, CloseDatabase> database_;
  std::unique_ptr<sqlite3_blob, CloseBlob> blob_;  // the latest message
};

class Ros2Bag : public Bag {
 public:
  Result<void> open(const std::vector<std::filesystem::path>& files) {
    std::map<std::string, BagTopic> topics;
    for (const std::filesystem::path& file : files) {
      files_.emplace_back(file);
      if (auto opened = files_.back().open(); !opened) return opened;
      if (auto listed = list(files_.size() - 1, topics); !listed) return listed;
    }
    for (auto& [name, topic] : topics) {
      std::stable_sort(topic.messages.begin(), topic.messages.end(),
                       [](const BagMessage& a, const BagMessage& b) { return a.time < b.time; });
      topics_.push_back(std::move(topic));
    }
    return {};
  }

  RosWire wire() const override { return RosWire::cdr; }
  const std::vector<BagTopic>& topics() const override { return topics_; }

  Result<void> read(const BagMessage& message, std::string& bytes, size_t most) override {
    const std::lock_guard lock(mutex_);
    return files_[message.file].read(message.row, bytes, most);
  }

 private:
  Result<void> list(size_t number, std::map<std::string, BagTopic>& topics) {
    BagFile& file = files_[number];
    std::map<int64_t, BagTopic*> listed;  // by topic_id
    auto selected =
        file.select("SELECT id, name, type, serialization_format FROM topics", [&](sqlite3_stmt* row) -> Result<void> {
          const std::string name = text_at(row, 1), type = type_of_ros1(text_at(row, 2)), format = text_at(row, 3);
          BagTopic& topic = topics[name];
          topic.name = name;
          topic.type = type;
          if (!is_listed_type(type)) return {};
          if (format != "cdr") {
            return fail(file.file().string() + ": topic " + name + " has serialization_format '" + format +
                        "', it must be cdr");
          }
          listed[sqlite3_column_int64(row, 0)] = &topic;
          return {};
        });
    if (!selected) return selected;
    return file.select("SELECT id, topic_id, timestamp FROM messages", [&](sqlite3_stmt* row) -> Result<void> {
      const auto topic = listed.find(sqlite3_column_int64(row, 1));
      if (topic != listed.end())
        topic->second->messages.push_back({sqlite3_column_int64(row, 2), number, sqlite3_column_int64(row, 0)});
      return {};
    });
  }

  std::vector<BagTopic> topics_;
  std::mutex mutex_;
  std::vector<BagFile> files_;  // guarded by mutex_
};

}  // namespace

Result<std::unique_ptr<Bag>> open_ros2_bag(const std::vector<std::filesystem::path>& files) {
  auto bag = std::make_unique<Ros2Bag>();
  if (auto opened = bag->open(files); !opened) return tl::unexpected(opened.error());
  return bag;
}

}  // namespace covis::io
