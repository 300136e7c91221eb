#include "report.hpp"

#include <unistd.h>

#include <fstream>
#include <stdexcept>

namespace recon_bench {
namespace {

std::vector<std::string> split_line(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      cells.emplace_back();
    else
      cells.back() += c;
  }
  return cells;
}

}  // namespace

Table read_table(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  if (!file || !std::getline(file, line)) throw std::runtime_error("cannot read " + path.string());
  Table table(path.stem().string(), split_line(line));
  while (std::getline(file, line)) table.add(split_line(line));
  return table;
}

void write_report(const Context& context,
                  const std::vector<std::pair<std::string, std::string>>& machine,
                  const Summary& summary, const Checks& checks,
                  const std::vector<Section>& sections) {
  const auto path = context.out / "report.md";
  std::ofstream file(path);
  file << "# Benchmarks of recon\n\n";
  if (context.smoke)
    file << "**A smoke test: every case once on a tiny workload. The times mean nothing.**\n\n";
  else if (context.quick)
    file << "A quick run: fewer rounds and smaller sizes than the full one.\n\n";
  for (const auto& [name, text] : machine) file << "- " << name << ": " << text << "\n";
  file << "\n## Aims\n\n"
       << summary.met() << " of " << summary.aims()
       << " aims met. The goal says which way the ratio should go; lines without a goal are "
          "reported "
          "only.\n\n"
       << summary.table().markdown() << "\n## Checks\n\n"
       << checks.done() << " answers checked before they were timed, " << checks.failures().size()
       << " wrong. The largest difference was " << number(checks.worst()) << " of its tolerance.\n";
  for (const std::string& failure : checks.failures()) file << "- WRONG: " << failure << "\n";
  for (const Section& section : sections) {
    file << "\n## " << section.title << "\n\n" << section.text << "\n";
    for (const Table& table : section.tables) {
      table.write_csv(context.out);
      file << "\n`" << table.name() << ".csv`\n\n" << table.markdown();
    }
    for (const std::string& picture : section.pictures)
      file << "\n![" << picture << "](" << picture << ".png)\n";
  }
  summary.table().write_csv(context.out);
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path.string());
}

Draft::Draft(std::filesystem::path target) : target_(std::move(target)) {
  if (target_.filename().empty()) target_ = target_.parent_path();
  folder_ = target_;
  folder_ += ".draft-" + std::to_string(getpid());
  std::filesystem::create_directories(folder_);
}

Draft::~Draft() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void Draft::publish() {
  std::filesystem::create_directories(target_);
  for (const auto& entry : std::filesystem::directory_iterator(folder_))
    std::filesystem::rename(entry.path(), target_ / entry.path().filename());
}

}  // namespace recon_bench
