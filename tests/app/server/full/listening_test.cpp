#include "tests/listening_sockets.hpp"

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <future>
#include <gtest/gtest.h>
#include <set>
#include <string>
#include <thread>
#include <unistd.h>

#include "app/server/serve.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "tests/child.hpp"
#include "tests/samples/small_bar.hpp"
#include "tests/samples/test_meshes.hpp"
#include "tests/web_client.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;
using boost::asio::ip::tcp;

/// By conjugate gradients with algebraic multigrid, which run on MPI.
core::Solution solved_by_iterations() {
    const auto body = tests::make_body(tests::box_mesh({0.06, 0.02, 0.02}, {6, 2, 2}), {1000.0, 5000.0, 0.3});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    tests::pull(load_case, body->mesh, "x_max", {100.0, 0.0, 0.0});
    return fem_reference::solve_static({body, load_case}, 2, fem_reference::SolverChoice::iterative);
}

TEST(Listening, StartsWithNobodyForAnIterativeSolveInOneProcess) {
    // That it would be found: this is what a library opens.
    boost::asio::io_context context;
    {
        const tcp::acceptor everywhere(context, {tcp::v6(), 0});
        EXPECT_EQ(tests::listening(getpid()).size(), 1U);
    }
    ASSERT_EQ(setenv("OMPI_MCA_btl", "self,tcp", 1), 0);
    const auto solution = solved_by_iterations();
    EXPECT_EQ(solution.status, core::SolutionStatus::ok);
    EXPECT_NE(solution.solver.find("ML"), std::string::npos) << solution.solver;
    EXPECT_EQ(tests::listening(getpid()), std::set<std::string>{});
    EXPECT_EQ(tests::descendants(getpid()), std::set<pid_t>{});
    EXPECT_STREQ(getenv("OMPI_MCA_btl"), "self,tcp");
    EXPECT_EQ(getenv("OMPI_MCA_ess_singleton_isolated"), nullptr);
    unsetenv("OMPI_MCA_btl");
}

TEST(Listening, DuringARunIsNobody) {
    const auto folder = tests::folder_with_bar("listening");
    std::ofstream(folder / "pull.toml")
        << "title = \"pull\"\ntarget_peak_displacement = 0.001\n[[condition]]\npatch = \"x_min\"\n"
           "displacement = [0.0, 0.0, 0.0]\n[[condition]]\npatch = \"x_max\"\ntraction = [10.0, 0.0, 0.0]\n";
    std::set<std::string> heard;
    std::size_t num_looks = 0;
    const auto look = [&] {
        for (const auto process : tests::descendants(getpid())) {
            heard.merge(tests::listening(process));
            ++num_looks;
        }
        return false;
    };
    const auto end = tests::run_child({LIVERMARK_BINARY, "run", "--body", (folder / "bar.toml").string(), "--load-case",
                                       (folder / "pull.toml").string(), "--model", "fem_p2", "--fem-solver",
                                       "iterative", "--reference-on-mesh", "--output", (folder / "runs").string()},
                                      {.killed_when = look});
    EXPECT_EQ(end.status, 0) << end.output << end.errors;
    EXPECT_GT(num_looks, 10U);
    EXPECT_EQ(heard, std::set<std::string>{});
}

/// A server whose session solves by iterations.
class Served {
  public:
    Served() {
        std::promise<std::uint16_t> is_ready;
        auto port_in_future = is_ready.get_future();
        thread_ = std::thread([is_ready = std::move(is_ready)]() mutable {
            server::Site site{.folder = "/nowhere",
                              .page = "/nowhere/index.html",
                              .port = 0,
                              .token = tests::token,
                              .is_result_file = {},
                              .sessions = {{"/solve", [](const server::Fields &, const server::ReportProgress &) {
                                                return [](const server::Message &) -> server::Message {
                                                    return {false, solved_by_iterations().solver};
                                                };
                                            }}}};
            server::serve(std::move(site), [&](std::uint16_t port) { is_ready.set_value(port); });
        });
        port = port_in_future.get();
    }
    ~Served() {
        kill(getpid(), SIGINT);
        thread_.join();
    }
    std::uint16_t port = 0;

  private:
    std::thread thread_;
};

TEST(Listening, OfTheServerIsOneSocketForThisMachineThatItsChildrenDoNotGet) {
    const Served served;
    const std::set<std::string> own{fmt::format("0100007F:{:04X}", served.port)};
    tests::WebSocketClient client(served.port);
    ASSERT_TRUE(client.open("/solve"));
    EXPECT_NE(client.reply_to("go").find("ML"), std::string::npos);
    EXPECT_EQ(tests::listening(getpid()), own);
    // A child, while connections are open: `sleep` has what is not closed on exec.
    const auto process = fork();
    if (process == 0) {
        execlp("sleep", "sleep", "30", static_cast<char *>(nullptr));
        _exit(1);
    }
    std::string name;
    while (name != "sleep")
        std::ifstream(fmt::format("/proc/{}/comm", process)) >> name;
    EXPECT_EQ(tests::listening(process), std::set<std::string>{});
    std::set<std::string> sockets_of_child;
    for (const auto &entry : fs::directory_iterator(fmt::format("/proc/{}/fd", process)))
        if (const auto target = fs::read_symlink(entry.path()).string(); target.starts_with("socket:"))
            sockets_of_child.insert(target);
    kill(process, SIGKILL);
    EXPECT_LE(sockets_of_child.size(), 1U); // the client's of this test, which is in the same process
}

} // namespace
} // namespace livermark
