#include "server/site.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <optional>
#include <string>
#include <unistd.h>
#include <vector>

#include "results/result_files.hpp"

namespace livermark::server {
namespace {

namespace fs = std::filesystem;

void write(const fs::path &path, const std::string &text = "text") {
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
}

/// A folder with results, and a secret beside it.
class SiteTest : public testing::Test {
  protected:
    SiteTest() {
        write(results / "liver" / "pull.h5");
        write(results / "a b%\".h5");
        write(results / "notes.txt");
        write(top / "secret.h5");
        write(top / "results_of_others" / "theirs.h5");
    }
    ~SiteTest() override { fs::remove_all(top); }

    int status(const std::string &target, const std::string &method = "GET") const {
        return answer({.method = method, .target = target, .host = "127.0.0.1:8421", .origin = {}}, site).status;
    }
    int status_of(const std::string &host, const std::optional<std::string> &origin) const {
        return answer({.method = "GET", .target = "/", .host = host, .origin = origin}, site).status;
    }

    const fs::path top = fs::temp_directory_path() / ("livermark_site_" + std::to_string(getpid()));
    const fs::path results = top / "results";
    const Site site{.folder = results,
                    .page = "/somewhere/index.html",
                    .port = 8421,
                    .is_result_file = [](const fs::path &) { return true; }};
};

TEST_F(SiteTest, ServesThePageAndTheFilesOfTheFolder) {
    const Request request{.method = "GET", .target = "/files/liver/pull.h5", .host = "localhost:8421", .origin = {}};
    EXPECT_EQ(answer(request, site).file, results / "liver" / "pull.h5");
    EXPECT_EQ(status("/"), 200);
    EXPECT_EQ(status("/?anything"), 200);
    EXPECT_EQ(status("/", "HEAD"), 200);
    EXPECT_EQ(status("/files/a%20b%25%22.h5"), 200);
}

TEST_F(SiteTest, ListsResultFilesByNameAsJson) {
    const Request request{.method = "GET", .target = "/files.json", .host = "localhost:8421", .origin = {}};
    EXPECT_EQ(answer(request, site).text, R"([{"path":"a b%\".h5","bytes":4},{"path":"liver/pull.h5","bytes":4}])");
    auto choosy = site;
    choosy.is_result_file = results::is_result_file;
    EXPECT_EQ(answer(request, choosy).text, "[]");
}

TEST_F(SiteTest, NeverLeavesTheFolder) {
    for (const auto *target :
         {"/files/../secret.h5", "/files/%2e%2e/secret.h5", "/files/..%2fsecret.h5", "/files/liver/../../secret.h5",
          "/files/../results_of_others/theirs.h5", "/files//etc/passwd", "/files/%2fetc%2fpasswd", "/../secret.h5",
          "/files/liver/../liver/pull.h5", "/files/./liver/pull.h5", "/files/secret.h5%00.h5", "/files/",
          "/files/liver", "/files/notes.txt", "/secret.h5", "/files", ""})
        EXPECT_EQ(status(target), 404) << target;
    EXPECT_EQ(status("/files/" + (top / "secret.h5").string()), 404);
    EXPECT_EQ(status("http://127.0.0.1:8421/"), 404);
}

TEST_F(SiteTest, FollowsLinksWithinTheFolderOnly) {
    fs::create_symlink(top / "secret.h5", results / "out.h5");
    fs::create_directory_symlink(top / "results_of_others", results / "others");
    fs::create_symlink(results / "notes.txt", results / "disguised.h5");
    fs::create_symlink(results / "liver" / "pull.h5", results / "again.h5");
    EXPECT_EQ(status("/files/out.h5"), 404);
    EXPECT_EQ(status("/files/others/theirs.h5"), 404);
    EXPECT_EQ(status("/files/disguised.h5"), 404);
    EXPECT_EQ(status("/files/again.h5"), 200);
    EXPECT_EQ(result_files(site), (std::vector<std::string>{"a b%\".h5", "again.h5", "liver/pull.h5"}));
}

TEST_F(SiteTest, AnswersItsOwnPagesOnly) {
    EXPECT_EQ(status_of("127.0.0.1:8421", std::nullopt), 200);
    EXPECT_EQ(status_of("localhost:8421", "http://localhost:8421"), 200);
    EXPECT_EQ(status_of("localhost:8421", "http://127.0.0.1:8421"), 200);
    for (const auto *host : {"", "localhost", "localhost:84210", "localhost:842", "evil:8421", "localhost.evil:8421",
                             "127.0.0.1:8421, 127.0.0.1:8421", "127.0.0.1:8421 ", "LOCALHOST:8421", "0.0.0.0:8421"})
        EXPECT_EQ(status_of(host, std::nullopt), 403) << host;
    for (const auto *origin : {"", "null", "http://localhost", "https://localhost:8421", "http://localhost.evil:8421",
                               "http://localhost:8421.evil", "http://localhost:84211", "localhost:8421",
                               "http://evil/http://localhost:8421", "file://"})
        EXPECT_EQ(status_of("127.0.0.1:8421", origin), 403) << origin;
}

TEST_F(SiteTest, OnlyShows) {
    for (const auto *method : {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "get", ""})
        EXPECT_EQ(status("/", method), 405) << method;
}

TEST_F(SiteTest, RefusesAnAddressThatIsNotWellFormed) {
    for (const auto *target : {"/files/%", "/files/%2", "/files/%zz.h5", "/%+1"})
        EXPECT_EQ(status(target), 400) << target;
}

} // namespace
} // namespace livermark::server
